#include "learner/record/inspect.h"

#include <iomanip>
#include <nlohmann/json.hpp>

#include "common/config/config_fields.h"
#include "common/numbers/elementary.h"
#include "common/policy/network.h"

namespace metronome::record {
namespace {

std::vector<double> HeadStd(const checkpoint::Checkpoint& checkpoint) {
  const policy::NetworkShape shape = policy::ShapeOf(checkpoint.config);
  if (shape.squashed) return {};  // of the state
  std::size_t at = policy::ActorLayout(shape).log_std;
  std::vector<double> std_of_head;
  for (int head = 0; head < shape.heads; ++head) {
    double sum = 0;
    for (int i = 0; i < shape.action; ++i)
      sum += numbers::Exp(double{checkpoint.state.policy.parameters[at++]});
    std_of_head.push_back(sum / shape.action);
  }
  return std_of_head;
}

std::string PolicyWord(const RunConfig& config, const std::string& field) {
  return config::FieldText(config.policy(), *PolicyConfig::descriptor()->FindFieldByName(field));
}

using Json = nlohmann::ordered_json;

/// A path may not be text.
std::string Dump(const Json& json) {
  return json.dump(-1, ' ', false, Json::error_handler_t::replace);
}

Json Describe(const checkpoint::Checkpoint& checkpoint) {
  const RunConfig& config = checkpoint.config;
  const checkpoint::TrainState& state = checkpoint.state;
  Json description = {
      {"version", state.version},
      {"steps", state.steps},
      {"weights_sha256", state.weights.sha256},
      {"task", config.environment().task()},
      {"algorithm", state.algorithm.name},
      {"algorithm_format", state.algorithm.format},
      {"method", PolicyWord(config, "method")},
      {"heads", config.policy().heads()},
      {"schedule", PolicyWord(config, "schedule")},
      {"critic_heads", PolicyWord(config, "critic_heads")},
      {"seed", config.seed()},
      {"engine", checkpoint.engine},
      {"build", checkpoint.build},
      {"isa", checkpoint.isa},
      {"incarnation", checkpoint.incarnation},
      {"episodes_used", state.episodes_used},
      {"total_steps", config.total_steps()},
      {"parameters", state.weights.count},
      {"actor_parameters", state.policy.parameters.size()},
      {"critic_parameters", state.weights.count - state.policy.parameters.size()},
      {"wall_seconds", checkpoint.logs.wall_seconds},
      {"head_std", HeadStd(checkpoint)},
  };
  if (!checkpoint.initial_weights_sha256.empty()) {
    description["initial_weights"] = config.policy().initial_weights();
    description["initial_weights_sha256"] = checkpoint.initial_weights_sha256;
  }
  return description;
}

}  // namespace

void PrintCheckpoint(const checkpoint::Checkpoint& checkpoint, std::ostream& out) {
  const Json description = Describe(checkpoint);
  for (const auto& [name, value] : description.items()) {
    out << std::left << std::setw(18) << name + " "
        << (value.is_string() ? value.get<std::string>() : Dump(value)) << "\n";
  }
}

void PrintCheckpointJson(const checkpoint::Checkpoint& checkpoint, std::ostream& out) {
  out << Dump(Describe(checkpoint)) << "\n";
}

}  // namespace metronome::record
