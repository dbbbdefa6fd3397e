#pragma once

#include <functional>
#include <string>

#include "common/schema/config.pb.h"

/// How a configuration comes to say what its environment is like.
namespace metronome::config {

/// Describes the environment of a name: the registry of an actor, or that program's word.
/// @throws std::invalid_argument for a name that it does not know (near miss and list), ConfigError
///         where nothing can be asked.
using SpecSource = std::function<EnvironmentSpec(const std::string& name)>;

/// Whether `config` has the specification of the environment that it names.
bool HasSpec(const RunConfig& config);

/// Gives `config` the specification of the environment that it names, and environment.task its
/// short name. Who has it is not asked again; without a name nothing happens.
/// @throws ConfigError for a name that `source` does not know, and what `source` throws else.
void CompleteSpec(RunConfig& config, const SpecSource& source);

}  // namespace metronome::config
