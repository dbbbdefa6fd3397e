#include "tests/learning/orders.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <memory>
#include <utility>

namespace metronome::test {
namespace {

class OrdersEnvironment final : public environment::Environment {
 public:
  explicit OrdersEnvironment(OrderRules rules) : rules_(std::move(rules)) {}

  void Reset(environment::EpisodeStart& /*start*/, std::span<float> observation) override {
    steps_ = 0;
    std::fill(observation.begin(), observation.end(), 0.0F);
    due_.assign(observation.begin(), observation.end());
  }

  environment::StepOutcome Step(std::span<const float> action,
                                std::span<float> observation) override {
    const double order = action[0];
    const double share = (1 + double{action[1]}) / 2;
    environment::StepOutcome outcome;
    outcome.reward = share * rules_.worth.at(steps_) * due_.front() - order * order / 2;
    due_.erase(due_.begin());
    due_.push_back(action[0]);
    ++steps_;
    outcome.terminated = rules_.terminates && steps_ == rules_.worth.size();
    std::copy(due_.begin(), due_.end(), observation.begin());
    return outcome;
  }

 private:
  OrderRules rules_;
  std::vector<float> due_;
  std::size_t steps_ = 0;
};

}  // namespace

environment::EnvironmentEntry Orders(const OrderRules& rules) {
  environment::EnvironmentEntry entry;
  entry.spec.set_name("test/orders");
  entry.spec.set_short_name("orders");
  entry.spec.set_observation_size(rules.delay);
  entry.spec.set_action_size(2);
  for (int i = 0; i < 2; ++i) {
    entry.spec.add_action_low(-1);
    entry.spec.add_action_high(1);
  }
  entry.spec.set_max_steps(std::int32_t(rules.worth.size()));
  entry.spec.set_may_end_early(false);
  entry.spec.set_has_success(false);
  entry.make = [rules](const EnvironmentConfig&) {
    return std::make_unique<OrdersEnvironment>(rules);
  };
  return entry;
}

double BestReturn(const OrderRules& rules, double discount) {
  double best = 0;
  for (std::size_t t = std::size_t(rules.delay); t < rules.worth.size(); ++t) {
    const double order = std::pow(discount, rules.delay) * rules.worth[t];  // delay steps before
    best += order * rules.worth[t] - order * order / 2;
  }
  return best;
}

}  // namespace metronome::test
