#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "actor/environment/environment.h"
#include "common/schema/config.pb.h"

namespace metronome::environment {

/// An environment that a program can play: a row of its table.
struct EnvironmentEntry {
  EnvironmentSpec spec;
  std::vector<std::string> aliases;  // other names than the specification's two
  /// Makes one for a run's `config`; its placements and goal are the environment's to heed.
  /// @throws std::invalid_argument for what it does not have, std::runtime_error naming the remedy
  /// for what this machine lacks.
  std::function<std::unique_ptr<Environment>(const EnvironmentConfig& config)> make;
  /// How many starts an evaluation with that configuration has that differ from each other; unset,
  /// or std::nullopt: no two are alike.
  std::function<std::optional<std::int32_t>(const EnvironmentConfig& config)> different_starts;
};

/// Several tasks under one name.
struct TaskGroup {
  std::string name;
  std::vector<std::string> tasks;  // short names, in the order that a one-hot has
  bool has_benchmark = false;      // its tasks know PLACEMENTS_BENCHMARK under this name
};

/// The environments of one program, by name. Immutable, hence thread-safe.
class EnvironmentRegistry {
 public:
  /// @param require_machine  throws std::runtime_error naming the remedy if the machine lacks what
  ///                         they all need.
  /// @throws std::logic_error if two entries or groups share a name.
  explicit EnvironmentRegistry(std::vector<EnvironmentEntry> entries,
                               std::function<void()> require_machine = {},
                               std::vector<TaskGroup> groups = {});

  /// One environment. @throws std::invalid_argument for an unknown name: near miss and list.
  [[nodiscard]] const EnvironmentEntry& Find(const std::string& name) const;
  /// The short names of the tasks that `name` means: an environment's, a group's, or those of a
  /// list (push,door-open). @throws as Find, and std::invalid_argument for a task given twice.
  [[nodiscard]] std::vector<std::string> TasksOf(const std::string& name) const;
  /// One environment, or several tasks together: a SpecSource. @throws as TasksOf, and
  /// std::invalid_argument for tasks whose observations, actions or lengths differ.
  [[nodiscard]] EnvironmentSpec Describe(const std::string& name) const;
  /// The environment of a run, of several tasks that of number `task`.
  /// @throws as Describe and as its `make`, and std::invalid_argument if the configuration's
  /// specification is not the one here: the learner means another environment.
  [[nodiscard]] std::unique_ptr<Environment> Make(const EnvironmentConfig& config,
                                                  std::size_t task = 0) const;

  [[nodiscard]] const std::vector<EnvironmentEntry>& entries() const { return entries_; }
  [[nodiscard]] const std::vector<TaskGroup>& groups() const { return groups_; }
  void RequireMachine() const;

 private:
  [[nodiscard]] const TaskGroup* FindGroup(const std::string& name) const;

  std::vector<EnvironmentEntry> entries_;
  std::map<std::string, std::size_t> by_name_;  // of an entry by each of its names
  std::function<void()> require_machine_;
  std::vector<TaskGroup> groups_;
};

}  // namespace metronome::environment
