#include "common/process/cpu_count.h"

#include <algorithm>
#include <cmath>
#include <fstream>
#include <sstream>
#include <thread>
#include <vector>

namespace metronome::process {
namespace {

/// A hierarchy of control groups that can limit CPU time, and our group in it.
struct Hierarchy {
  bool unified = false;  // cgroup v2
  std::string group;     // as /proc/self/cgroup names it
};

/// Where a hierarchy is to be seen.
struct Mount {
  bool unified = false;
  std::string group;   // the one that is shown there
  std::string folder;  // where
};

std::vector<std::string> SplitAt(const std::string& text, char separator) {
  std::vector<std::string> parts;
  std::istringstream in(text);
  for (std::string part; std::getline(in, part, separator);) parts.push_back(part);
  return parts;
}

bool Names(const std::string& list, const std::string& word) {
  const auto words = SplitAt(list, ',');
  return std::find(words.begin(), words.end(), word) != words.end();
}

// Lines of proc(5) "cgroup": ID:CONTROLLERS:GROUP; of v2 the controllers are empty.
std::vector<Hierarchy> HierarchiesIn(std::istream& lines) {
  std::vector<Hierarchy> found;
  for (std::string line; std::getline(lines, line);) {
    const auto first = line.find(':');
    const auto second = line.find(':', first + 1);
    if (first == std::string::npos || second == std::string::npos) continue;
    const std::string controllers = line.substr(first + 1, second - first - 1);
    if (controllers.empty() || Names(controllers, "cpu")) {
      found.push_back({controllers.empty(), line.substr(second + 1)});
    }
  }
  return found;
}

// Lines of proc(5) "mountinfo": ID PARENT DEVICE ROOT FOLDER ... - TYPE SOURCE OPTIONS.
std::vector<Mount> MountsIn(std::istream& lines) {
  std::vector<Mount> found;
  for (std::string line; std::getline(lines, line);) {
    const auto words = SplitAt(line, ' ');
    const auto dash = std::find(words.begin(), words.end(), "-");
    if (words.size() < 5 || words.end() - dash < 4) continue;
    const bool unified = dash[1] == "cgroup2";
    if (unified || (dash[1] == "cgroup" && Names(dash[3], "cpu"))) {
      found.push_back({unified, words[3], words[4]});
    }
  }
  return found;
}

std::optional<double> QuotaOf(const std::string& folder, bool unified) {
  double quota = 0;
  double period = 0;
  if (unified) {
    std::ifstream(folder + "/cpu.max") >> quota >> period;  // "max" is no number
  } else {
    std::ifstream(folder + "/cpu.cfs_quota_us") >> quota;  // -1: none
    std::ifstream(folder + "/cpu.cfs_period_us") >> period;
  }
  if (quota <= 0 || period <= 0) return std::nullopt;
  return quota / period;
}

/// The path of our group below the mount; the mount itself where the group lies outside of what it
/// shows, as in a container that sees its own group alone.
std::string GroupBelow(const Mount& mount, std::string group) {
  if (mount.group != "/") {
    const bool inside = group == mount.group || group.starts_with(mount.group + "/");
    group = inside ? group.substr(mount.group.size()) : "";
  }
  while (group.ends_with('/')) group.pop_back();
  return group.find("/..") == std::string::npos ? group : "";
}

}  // namespace

std::optional<double> CpuQuota(const std::string& root) {
  std::ifstream groups(root + "/proc/self/cgroup");
  std::ifstream mounts(root + "/proc/self/mountinfo");
  const auto hierarchies = HierarchiesIn(groups);
  std::optional<double> least;
  for (const Mount& mount : MountsIn(mounts)) {
    const std::string top = root + mount.folder;
    for (const Hierarchy& hierarchy : hierarchies) {
      if (hierarchy.unified != mount.unified) continue;
      std::string group = GroupBelow(mount, hierarchy.group);
      while (true) {
        const auto quota = QuotaOf(top + group, mount.unified);
        if (quota && (!least || *quota < *least)) least = quota;
        if (group.empty()) break;
        group.erase(group.rfind('/'));
      }
    }
  }
  return least;
}

int UsableCpus() {
  int cpus = static_cast<int>(std::max(1U, std::thread::hardware_concurrency()));
  if (const auto quota = CpuQuota()) cpus = std::min(cpus, static_cast<int>(std::ceil(*quota)));
  return cpus;
}

std::optional<std::string> TooManyThreads(int threads, const std::string& option) {
  const int usable = UsableCpus();
  if (threads <= usable) return std::nullopt;
  return option + " asks for " + std::to_string(threads) + " threads, but this process can keep " +
         std::to_string(usable) + (usable == 1 ? " CPU" : " CPUs") +
         " busy (cores, affinity, CPU quota): more threads than that make it slower";
}

}  // namespace metronome::process
