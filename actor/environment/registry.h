#pragma once

#include <cstdint>
#include <functional>
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

/// The environments of one program, by name. Immutable, hence thread-safe.
class EnvironmentRegistry {
 public:
  /// @param require_machine  throws std::runtime_error naming the remedy if the machine lacks what
  ///                         they all need.
  /// @throws std::logic_error if two entries share a name.
  explicit EnvironmentRegistry(std::vector<EnvironmentEntry> entries,
                               std::function<void()> require_machine = {});

  /// @throws std::invalid_argument for an unknown name: near miss and list.
  [[nodiscard]] const EnvironmentEntry& Find(const std::string& name) const;
  /// As Find: a SpecSource.
  [[nodiscard]] EnvironmentSpec Describe(const std::string& name) const { return Find(name).spec; }
  /// The environment of a run. @throws as Find and as its `make`, and std::invalid_argument if the
  /// configuration's specification is not the entry's: the learner means another environment.
  [[nodiscard]] std::unique_ptr<Environment> Make(const EnvironmentConfig& config) const;

  [[nodiscard]] const std::vector<EnvironmentEntry>& entries() const { return entries_; }
  void RequireMachine() const;

 private:
  std::vector<EnvironmentEntry> entries_;
  std::function<void()> require_machine_;
};

}  // namespace metronome::environment
