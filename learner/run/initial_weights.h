#pragma once

#include <string>
#include <vector>

#include "common/checkpoint/checkpoint.h"
#include "common/schema/config.pb.h"

/// policy.initial_weights (--from): a new run that begins with the weights of another one.
namespace metronome::run {

/// The checkpoint that `config` (resolved) names. @param specs  see DecodeCheckpoint.
/// @throws ConfigError if it cannot be used, or if its algorithm or network is another one: names
///         algorithm, method, heads or sizes.
checkpoint::Checkpoint LoadInitialWeights(const RunConfig& config, const config::SpecSource& specs);

/// How else the weights were trained than this run, with this engine, will train them: a line for
/// each difference of the environment, of the policy and of the engine.
struct TrainingDifferences {
  std::vector<std::string> intended;  // what such runs are for: another task, horizon, ...
  std::vector<std::string> doubtful;  // the heads meant something else
};
TrainingDifferences DifferencesFrom(const checkpoint::Checkpoint& source, const RunConfig& config);

}  // namespace metronome::run
