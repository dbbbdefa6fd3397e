#include "actor/environment/registry.h"

#include <algorithm>
#include <set>
#include <stdexcept>
#include <utility>

#include "common/text/near_miss.h"

namespace metronome::environment {
namespace {

std::vector<std::string> NamesOf(const EnvironmentEntry& entry) {
  std::vector<std::string> names = {entry.spec.short_name(), entry.spec.name()};
  names.insert(names.end(), entry.aliases.begin(), entry.aliases.end());
  if (names[0] == names[1]) names.erase(names.begin());
  return names;
}

std::string Joined(const std::vector<std::string>& tasks) {
  std::string joined;
  for (const std::string& task : tasks) joined += (joined.empty() ? "" : ",") + task;
  return joined;
}

/// One policy plays both. @throws std::invalid_argument if it cannot.
void Join(EnvironmentSpec& spec, const EnvironmentSpec& other) {
  const auto actions = [](const EnvironmentSpec& of) {
    return std::pair(std::vector(of.action_low().begin(), of.action_low().end()),
                     std::vector(of.action_high().begin(), of.action_high().end()));
  };
  if (spec.observation_size() != other.observation_size() || actions(spec) != actions(other)) {
    throw std::invalid_argument("impossible list: no policy plays both " + spec.short_name() +
                                " and " + other.short_name() + ", which have observations of " +
                                std::to_string(spec.observation_size()) + " and " +
                                std::to_string(other.observation_size()) + " numbers, actions of " +
                                std::to_string(spec.action_size()) + " and " +
                                std::to_string(other.action_size()) + ", or differ in bounds");
  }
  spec.set_max_steps(std::min(spec.max_steps(), other.max_steps()));
  spec.set_may_end_early(spec.may_end_early() || other.may_end_early());
  spec.set_has_success(spec.has_success() && other.has_success());
}

}  // namespace

EnvironmentRegistry::EnvironmentRegistry(std::vector<EnvironmentEntry> entries,
                                         std::function<void()> require_machine,
                                         std::vector<TaskGroup> groups)
    : entries_(std::move(entries)),
      require_machine_(std::move(require_machine)),
      groups_(std::move(groups)) {
  const auto require = [](bool is_new, const std::string& name) {
    if (!is_new) throw std::logic_error("two environments are called " + name);
  };
  for (std::size_t i = 0; i < entries_.size(); ++i) {
    for (const std::string& name : NamesOf(entries_[i])) {
      require(by_name_.emplace(name, i).second, name);
    }
  }
  for (const TaskGroup& group : groups_) {
    require(!by_name_.contains(group.name) && FindGroup(group.name) == &group, group.name);
  }
}

const EnvironmentEntry& EnvironmentRegistry::Find(const std::string& name) const {
  if (const auto found = by_name_.find(name); found != by_name_.end()) {
    return entries_[found->second];
  }
  std::vector<std::string> known;
  std::vector<std::string> spellings;
  for (const EnvironmentEntry& entry : entries_) {
    known.push_back(entry.spec.short_name());
    for (const std::string& spelling : NamesOf(entry)) spellings.push_back(spelling);
  }
  for (const TaskGroup& group : groups_) known.push_back(group.name);
  auto near = text::NearMiss(name, known);
  if (!near) near = text::NearMiss(name, spellings);
  throw std::invalid_argument(text::UnknownName("environment", name, known, near));
}

const TaskGroup* EnvironmentRegistry::FindGroup(const std::string& name) const {
  const auto found = std::find_if(groups_.begin(), groups_.end(),
                                  [&name](const TaskGroup& group) { return group.name == name; });
  return found == groups_.end() ? nullptr : &*found;
}

std::vector<std::string> EnvironmentRegistry::TasksOf(const std::string& name) const {
  if (const TaskGroup* group = FindGroup(name)) return group->tasks;
  std::vector<std::string> tasks;
  std::set<std::string> seen;
  for (std::size_t begin = 0; begin <= name.size();) {
    const std::size_t end = std::min(name.find(',', begin), name.size());
    tasks.push_back(Find(name.substr(begin, end - begin)).spec.short_name());
    if (!seen.insert(tasks.back()).second)
      throw std::invalid_argument("impossible list \"" + name + "\": " + tasks.back() +
                                  " is in it twice");
    begin = end + 1;
  }
  return tasks;
}

EnvironmentSpec EnvironmentRegistry::Describe(const std::string& name) const {
  const std::vector<std::string> tasks = TasksOf(name);
  EnvironmentSpec spec = Find(tasks.front()).spec;
  const TaskGroup* group = FindGroup(name);
  if (tasks.size() == 1 && group == nullptr) return spec;
  for (const std::string& task : tasks) Join(spec, Find(task).spec);
  const std::string joined = group != nullptr ? group->name : Joined(tasks);
  spec.set_name(joined);
  spec.set_short_name(joined);
  spec.mutable_tasks()->Assign(tasks.begin(), tasks.end());
  if (group != nullptr && group->has_benchmark) spec.set_has_benchmark(true);
  return spec;
}

std::unique_ptr<Environment> EnvironmentRegistry::Make(const EnvironmentConfig& config,
                                                       std::size_t task) const {
  const EnvironmentSpec here = Describe(config.task());
  if (config.spec().SerializeAsString() != here.SerializeAsString()) {
    throw std::invalid_argument("the run's " + config.task() + " is " +
                                config.spec().ShortDebugString() + ", the one here is " +
                                here.ShortDebugString() + ": build both from the same sources");
  }
  return Find(TasksOf(config.task()).at(task)).make(config);
}

void EnvironmentRegistry::RequireMachine() const {
  if (require_machine_) require_machine_();
}

}  // namespace metronome::environment
