#include "actor/replay/task_list.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <string>
#include <vector>

#include "actor/metaworld/tasks/task_table.h"

namespace metronome::replay {
namespace {

constexpr std::size_t kColumns = 7;
using Row = std::array<std::string, kColumns>;

std::string Whole(double number) { return std::to_string(std::lround(number)); }
std::string Percent(double share) { return Whole(100 * share) + "%"; }

std::vector<Row> Rows() {
  std::vector<Row> rows = {{"task", "family", "numbers", "any", "last", "return", "success"}};
  for (const metaworld::TaskSpec& task : metaworld::tasks::AllTasks())
    rows.push_back({task.name, task.family, std::to_string(task.placement_size),
                    Percent(task.expert.success_any), Percent(task.expert.success_last),
                    Whole(task.expert.mean_return), task.success});
  return rows;
}

}  // namespace

int RunTasks(std::ostream& out) {
  const std::vector<Row> rows = Rows();
  std::array<std::size_t, kColumns> widths{};
  for (const Row& row : rows)
    for (std::size_t i = 0; i < kColumns; ++i) widths[i] = std::max(widths[i], row[i].size());
  for (const Row& row : rows) {
    for (std::size_t i = 0; i + 1 < kColumns; ++i)
      out << row[i] << std::string(widths[i] + 2 - row[i].size(), ' ');
    out << row.back() << '\n';
  }
  out << std::flush;
  return out ? 0 : 1;
}

}  // namespace metronome::replay
