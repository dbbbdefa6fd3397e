#pragma once

#include <string>
#include <vector>

#include "common/config/config_fields.h"
#include "common/config/config_file.h"
#include "common/config/environment_spec.h"
#include "common/schema/config.pb.h"

/// The life of a configuration: draft (files < --set < options), complete by the environment's
/// specification, resolve, validate, print, compare.
/// Field meanings and defaults: common/schema/config.proto. No function keeps state; all are
/// thread-safe.
namespace metronome::config {

/// Fills every unset field with its default, the derived ones too (heads and minibatch by what else
/// is set, the horizon by the environment's specification, see CompleteSpec).
/// Never fails: what cannot be right is left for Validate.
RunConfig Resolve(RunConfig config);

/// Checks each field of a resolved configuration and how they fit together.
/// @param origins  shown with the complaint where known.
/// @throws ConfigError with one line per complaint: field, value, what is allowed.
void Validate(const RunConfig& config, const ConfigOrigins& origins = {});

/// Text format with every field, to be read back by ParseConfigText.
std::string PrintConfig(const RunConfig& config);

/// Why a run of `old_config` cannot go on under `new_config` (both resolved): one line per
/// difference outside `runtime`. Empty: it can.
/// @param new_total_allowed  --new-total was given: total_steps may differ.
std::vector<std::string> CompareForResume(const RunConfig& old_config, const RunConfig& new_config,
                                          bool new_total_allowed);

/// The algorithm that a resolved configuration asks for: "ppo", or what custom.name says.
std::string AlgorithmName(const RunConfig& config);

/// A run's name becomes a folder and a DDS partition.
/// @throws ConfigError unless it has 1 to 64 letters, digits, '.', '_' or '-' and starts with a
///         letter or digit.
void CheckRunName(const std::string& name);

/// Collects a configuration from its sources and remembers where each value came from. Later calls
/// override earlier ones: call ReadFile, then SetFromArgument, then Set. Not thread-safe.
class ConfigDraft {
 public:
  ConfigDraft() = default;
  /// Starts from a run's own configuration (--resume).
  explicit ConfigDraft(RunConfig base) : config_(std::move(base)) {}

  /// May be called again: a later file overrides an earlier one field by field, a list as a whole.
  /// @throws ConfigError, see ParseConfigFile; also for another algorithm than an earlier file's.
  void ReadFile(const std::string& path);
  /// @param name  ppo, sac, or what a CustomAlgorithm is called. @param origin  e.g. "--algorithm".
  /// @throws ConfigError if another one has been chosen.
  void ChooseAlgorithm(const std::string& name, const std::string& origin);
  /// @param argument  of --set: "ppo.learning_rate=3e-4". @throws ConfigError.
  void SetFromArgument(const std::string& argument);
  /// @param origin  e.g. "--heads". @throws ConfigError, see SetField.
  void Set(const std::string& path, const std::string& value, const std::string& origin);

  /// Completed by `source` (see CompleteSpec), resolved and validated. @throws ConfigError.
  [[nodiscard]] RunConfig Finish(const SpecSource& source) const;

 private:
  RunConfig config_;
  ConfigOrigins origins_;
};

}  // namespace metronome::config
