#include "common/task_names.h"

#include <algorithm>
#include <stdexcept>

#include "common/near_miss.h"

namespace metronome {

const std::vector<std::string>& TaskNames() {
  static const std::vector<std::string> names = {"assembly", "bin-picking", "box-close", "push"};
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
