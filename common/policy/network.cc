#include "common/policy/network.h"

#include <stdexcept>
#include <string>

#include "common/policy/task_of.h"

namespace metronome::policy {
namespace {

LayerSlice NextLayer(std::int32_t inputs, std::int32_t outputs, std::size_t& offset) {
  LayerSlice slice;
  slice.inputs = inputs;
  slice.outputs = outputs;
  slice.weight = offset;
  slice.bias = slice.weight + static_cast<std::size_t>(inputs) * static_cast<std::size_t>(outputs);
  offset = slice.bias + static_cast<std::size_t>(outputs);
  return slice;
}

}  // namespace

MlpLayout LayoutOf(std::int32_t inputs, const std::vector<std::int32_t>& hidden, std::int32_t heads,
                   std::int32_t head_outputs) {
  MlpLayout layout;
  std::size_t offset = 0;
  for (const std::int32_t width : hidden) {
    if (width < 1) throw std::invalid_argument("hidden width " + std::to_string(width) + " < 1");
    layout.hidden.push_back(NextLayer(inputs, width, offset));
    inputs = width;
  }
  layout.heads = heads;
  layout.head_outputs = head_outputs;
  layout.head = NextLayer(inputs, heads * head_outputs, offset);
  layout.log_std = offset;
  layout.size = offset;
  return layout;
}

MlpLayout ActorLayout(const NetworkShape& shape) {
  if (shape.squashed) return LayoutOf(shape.input(), shape.hidden, shape.heads, 2 * shape.action);
  MlpLayout layout = LayoutOf(shape.input(), shape.hidden, shape.heads, shape.action);
  layout.size += static_cast<std::size_t>(shape.heads) * static_cast<std::size_t>(shape.action);
  return layout;
}

MlpLayout CriticLayout(const NetworkShape& shape) {
  return LayoutOf(shape.critic_input(), shape.hidden, shape.critic_heads, shape.values);
}

std::size_t ParameterCount(const NetworkShape& shape) {
  return ActorLayout(shape).size + CriticLayout(shape).size;
}

NetworkShape ShapeOf(const RunConfig& config) {
  NetworkShape shape;
  const PolicyConfig& policy = config.policy();
  shape.time_feature = policy.method() == SINGLE_TIME;
  shape.critic_time = policy.critic_time() && !shape.time_feature;
  shape.observation = config.environment().spec().observation_size();
  shape.action = config.environment().spec().action_size();
  const EnvironmentConfig& environment = config.environment();
  shape.values = environment.reward() == REWARD_SUCCESS && environment.spec().has_success() &&
                         config.has_ppo() && config.ppo().success_weight() > 0
                     ? 2
                     : 1;
  shape.squashed = config.has_sac();
  shape.hidden.assign(policy.hidden().begin(), policy.hidden().end());
  shape.tasks = static_cast<std::int32_t>(TaskCount(config));
  shape.task_onehot = shape.tasks > 1 && config.environment().task_id() == TASK_ID_ONEHOT;
  shape.heads = policy.heads() * (policy.heads_by() == HEADS_BY_TIME ? 1 : shape.tasks);
  shape.critic_heads = policy.critic_heads() == CRITIC_HEADS_SHARED ? 1 : shape.heads;
  return shape;
}

}  // namespace metronome::policy
