#include "common/config/task_names.h"

#include <algorithm>
#include <iterator>
#include <sstream>
#include <stdexcept>

#include "common/text/near_miss.h"

namespace metronome {

const std::vector<std::string>& TaskNames() {
  // METRONOME_TASKS: from CMakeLists.txt, the names of the files in actor/metaworld/tasks.
  static const std::vector<std::string> names = [] {
    std::istringstream words(METRONOME_TASKS);
    return std::vector<std::string>(std::istream_iterator<std::string>(words), {});
  }();
  return names;
}

std::string CanonicalTaskName(const std::string& spelling) {
  std::string name = spelling;
  if (name.ends_with("-v2") || name.ends_with("-v3")) name.resize(name.size() - 3);
  const auto& names = TaskNames();
  if (std::find(names.begin(), names.end(), name) != names.end()) return name;
  throw std::invalid_argument(UnknownName("task", spelling, names, NearMiss(name, names)));
}

}  // namespace metronome
