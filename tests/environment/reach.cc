#include "tests/environment/reach.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <stdexcept>

namespace metronome::test {
namespace {

constexpr int kMaxSteps = 60;
constexpr double kArena = 1;     // half its width
constexpr double kStride = 0.1;  // the longest step
constexpr double kGoal = 0.1;    // its radius
constexpr double kLeast = 0.55;  // between start and goal: five steps

using Point = std::array<double, 2>;

double Distance(const Point& a, const Point& b) { return std::hypot(a[0] - b[0], a[1] - b[1]); }

/// Half the arena's width at most from its centre.
Point Draw(numbers::RandomStream& random) {
  const double x = random.Uniform() - 0.5;
  return {x, random.Uniform() - 0.5};
}

class ReachEnvironment final : public environment::Environment {
 public:
  void Reset(environment::EpisodeStart& start, std::span<float> observation) override {
    do {
      at_ = Draw(start.random);
      goal_ = Draw(start.random);
    } while (Distance(at_, goal_) < kLeast);
    const double way = Distance(at_, goal_);
    best_ = 1 + way - std::ceil((way - kGoal) / kStride) / kMaxSteps;
    stride_ = {};
    steps_ = 0;
    ended_ = false;
    Observe(observation);
  }

  environment::StepOutcome Step(std::span<const float> action,
                                std::span<float> observation) override {
    if (ended_) throw std::logic_error("Reach: the episode is over");
    const double size = std::max(1.0, std::hypot(double{action[0]}, double{action[1]}));
    if (!std::isfinite(size)) throw std::invalid_argument("Reach: the action is not finite");
    const double before = Distance(at_, goal_);
    for (std::size_t i = 0; i < 2; ++i) {
      stride_[i] = kStride * action[i] / size;
      at_[i] += stride_[i];
    }
    ++steps_;
    const double after = Distance(at_, goal_);
    environment::StepOutcome outcome;
    outcome.success = after <= kGoal;
    outcome.terminated = outcome.success || std::max(std::abs(at_[0]), std::abs(at_[1])) > kArena;
    outcome.truncated = !outcome.terminated && steps_ == kMaxSteps;
    outcome.reward = (outcome.success ? before + 1 : before - after) - 1.0 / kMaxSteps;
    outcome.reward /= best_;
    ended_ = outcome.terminated || outcome.truncated;
    Observe(observation);
    return outcome;
  }

 private:
  void Observe(std::span<float> observation) const {
    const std::array<double, 7> numbers = {
        at_[0], at_[1], goal_[0], goal_[1], stride_[0], stride_[1], Distance(at_, goal_)};
    std::transform(numbers.begin(), numbers.end(), observation.begin(),
                   [](double number) { return static_cast<float>(number); });
  }

  Point at_{}, goal_{}, stride_{};
  double best_ = 1;
  int steps_ = 0;
  bool ended_ = true;
};

}  // namespace

environment::EnvironmentEntry Reach() {
  environment::EnvironmentEntry entry;
  entry.spec.set_name("test/point");
  entry.spec.set_short_name("point");
  entry.spec.set_observation_size(7);
  entry.spec.set_action_size(2);
  for (int i = 0; i < 2; ++i) {
    entry.spec.add_action_low(-1);
    entry.spec.add_action_high(1);
  }
  entry.spec.set_max_steps(kMaxSteps);
  entry.spec.set_may_end_early(true);
  entry.spec.set_has_success(true);
  entry.make = [](const EnvironmentConfig& config) {
    if (config.placements() == PLACEMENTS_MT1) {
      throw std::invalid_argument("test/point has no mt1 placements");
    }
    return std::make_unique<ReachEnvironment>();
  };
  return entry;
}

}  // namespace metronome::test
