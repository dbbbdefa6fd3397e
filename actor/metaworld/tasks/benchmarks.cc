#include "actor/metaworld/tasks/benchmarks.h"

#include <iterator>
#include <sstream>
#include <stdexcept>

#include "actor/metaworld/tasks/task_table.h"
#include "common/text/near_miss.h"

namespace metronome::metaworld::tasks {
namespace {

std::vector<std::string> Words(const std::string& text) {
  std::istringstream stream(text);
  return {std::istream_iterator<std::string>(stream), {}};
}

}  // namespace

const std::vector<Benchmark>& AllBenchmarks() {
  static const std::vector<Benchmark> benchmarks = {
      {.name = "mt10",
       .train =
           Words("reach push pick-place door-open drawer-open drawer-close button-press-topdown "
                 "peg-insert-side window-open window-close"),
       .test = {}},
      {.name = "mt50",
       .train = Words(
           "assembly basketball bin-picking box-close button-press-topdown "
           "button-press-topdown-wall button-press button-press-wall coffee-button coffee-pull "
           "coffee-push dial-turn disassemble door-close door-lock door-open door-unlock "
           "hand-insert drawer-close drawer-open faucet-open faucet-close hammer "
           "handle-press-side handle-press handle-pull-side handle-pull lever-pull "
           "pick-place-wall pick-out-of-hole pick-place plate-slide plate-slide-side "
           "plate-slide-back plate-slide-back-side peg-insert-side peg-unplug-side soccer "
           "stick-push stick-pull push push-wall push-back reach reach-wall shelf-place "
           "sweep-into sweep window-open window-close"),
       .test = {}},
      {.name = "ml10",
       .train = Words(
           "reach push pick-place door-open drawer-close button-press-topdown peg-insert-side "
           "window-open sweep basketball"),
       .test = Words("drawer-open door-close shelf-place sweep-into lever-pull")},
      {.name = "ml45",
       .train = Words(
           "assembly basketball button-press-topdown button-press-topdown-wall button-press "
           "button-press-wall coffee-button coffee-pull coffee-push dial-turn disassemble "
           "door-close door-open drawer-close drawer-open faucet-open faucet-close hammer "
           "handle-press-side handle-press handle-pull-side handle-pull lever-pull "
           "pick-place-wall pick-out-of-hole push-back pick-place plate-slide plate-slide-side "
           "plate-slide-back plate-slide-back-side peg-insert-side peg-unplug-side soccer "
           "stick-push stick-pull push-wall push reach-wall reach shelf-place sweep-into sweep "
           "window-open window-close"),
       .test = Words("bin-picking box-close hand-insert door-lock door-unlock")},
  };
  return benchmarks;
}

const Benchmark& FindBenchmark(const std::string& name) {
  std::vector<std::string> names;
  for (const Benchmark& benchmark : AllBenchmarks()) {
    if (benchmark.name == name) return benchmark;
    names.push_back(benchmark.name);
  }
  throw std::invalid_argument(text::UnknownName("benchmark", name, names));
}

std::vector<TaskPlacements> BenchmarkPlacements(const std::vector<std::string>& tasks,
                                                std::uint32_t seed) {
  OfficialPlacements official(seed);
  std::vector<TaskPlacements> placements;
  placements.reserve(tasks.size());
  for (const std::string& name : tasks) {
    const TaskSpec& task = FindTask(name);
    placements.push_back({.task = &task, .placements = official.Next(task)});
  }
  return placements;
}

}  // namespace metronome::metaworld::tasks
