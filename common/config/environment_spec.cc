#include "common/config/environment_spec.h"

#include <stdexcept>

#include "common/config/config_fields.h"

namespace metronome::config {

bool HasSpec(const RunConfig& config) {
  const EnvironmentConfig& environment = config.environment();
  return environment.has_task() && (environment.task() == environment.spec().short_name() ||
                                    environment.task() == environment.spec().name());
}

void CompleteSpec(RunConfig& config, const SpecSource& source) {
  EnvironmentConfig& environment = *config.mutable_environment();
  if (!environment.has_task()) return;
  if (!HasSpec(config)) {
    try {
      *environment.mutable_spec() = source(environment.task());
    } catch (const ConfigError&) {
      throw;
    } catch (const std::invalid_argument& error) {
      throw ConfigError(std::string("environment.task is an ") + error.what());
    }
  }
  environment.set_task(environment.spec().short_name());
}

}  // namespace metronome::config
