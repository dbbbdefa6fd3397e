#include "learner/run/initial_weights.h"

#include <algorithm>
#include <map>

#include "common/config/config.h"
#include "common/policy/network.h"
#include "common/process/build_info.h"

namespace metronome::run {
namespace {

using Texts = std::map<std::string, std::string>;  // dotted path -> value

Texts TextsOf(const RunConfig& config) {
  Texts texts;
  config::VisitFields(config::Resolve(config),
                      [&](const std::string& path, const auto& owner, const auto& field) {
                        texts[path] = config::FieldText(owner, field);
                      });
  return texts;
}

std::string DifferenceOf(const std::string& path, const std::string& there,
                         const std::string& here) {
  return path + ": trained with " + there + ", this run has " + here;
}

void RequireSameAlgorithm(const checkpoint::Checkpoint& source, const RunConfig& config) {
  const std::string here = config::AlgorithmName(config);
  if (source.state.algorithm.name == here) return;
  throw config::ConfigError("--from " + config.policy().initial_weights() + ": its algorithm is " +
                            source.state.algorithm.name + ", this run's is " + here);
}

void RequireSameNetwork(const checkpoint::Checkpoint& source, const RunConfig& config) {
  const std::string& path = config.policy().initial_weights();
  const Texts there = TextsOf(source.config), here = TextsOf(config);
  std::vector<std::string> fields = {"policy.method", "policy.heads", "policy.hidden"};
  // With one head, separate and shared critics are the same network.
  if (policy::ShapeOf(source.config).critic_heads != policy::ShapeOf(config).critic_heads) {
    fields.emplace_back("policy.critic_heads");
  }
  if (policy::ShapeOf(source.config).critic_time != policy::ShapeOf(config).critic_time) {
    fields.emplace_back("policy.critic_time");
  }
  if (policy::ShapeOf(source.config).values != policy::ShapeOf(config).values) {
    fields.emplace_back("ppo.success_weight");
  }
  if (config.has_sac()) {
    // The limit says what the critics' outputs stand for.
    fields.insert(fields.end(),
                  {"sac.critic_hidden", "sac.critic_norm", "sac.bins", "sac.value_limit"});
  }
  const auto other = std::find_if(fields.begin(), fields.end(), [&](const std::string& field) {
    return there.at(field) != here.at(field);
  });
  if (other == fields.end()) return checkpoint::RequireShape(source, config, path);
  throw config::ConfigError("--from " + path + ": its " + *other + " is " + there.at(*other) +
                            ", this run's is " + here.at(*other) +
                            ": weights fit the same method, heads and sizes alone (--set " +
                            *other + "=" + there.at(*other) + ")");
}

}  // namespace

checkpoint::Checkpoint LoadInitialWeights(const RunConfig& config,
                                          const config::SpecSource& specs) {
  try {
    checkpoint::Checkpoint source =
        checkpoint::LoadCheckpoint(config.policy().initial_weights(), specs);
    checkpoint::RequireState(source, config.policy().initial_weights());
    RequireSameAlgorithm(source, config);
    RequireSameNetwork(source, config);
    return source;
  } catch (const checkpoint::CheckpointError& error) {
    throw config::ConfigError("--from: " + std::string(error.what()));
  }
}

TrainingDifferences DifferencesFrom(const checkpoint::Checkpoint& source, const RunConfig& config) {
  TrainingDifferences differences;
  const Texts there = TextsOf(source.config);
  for (const auto& [path, here] : TextsOf(config)) {
    const bool of_environment =
        path.starts_with("environment.") && !path.starts_with("environment.spec.");
    const bool of_heads = path == "policy.schedule" && config.policy().heads() > 1;
    const bool of_policy = of_heads || path == "policy.observation_clip" ||
                           path == "policy.observation_epsilon" ||
                           path == "policy.noise_correlation";
    if (there.at(path) == here || !(of_environment || of_policy)) continue;
    (of_heads ? differences.doubtful : differences.intended)
        .push_back(DifferenceOf(path, there.at(path), here));
  }
  if (source.engine != process::EngineName()) {
    differences.intended.push_back("engine: trained on " + source.engine + ", this run is on " +
                                   process::EngineName());
  }
  return differences;
}

}  // namespace metronome::run
