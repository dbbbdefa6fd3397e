#include "learner/ppo/ppo_loss.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <tuple>

namespace metronome::ppo {
namespace {

using Four = std::array<double, 4>;

struct Case {
  Four action, mean, log_std;
  double proximal, weight, advantage, clip;
};

// The objective straight from the papers, in double, as a function of mean and log-std.
double Loss(const Case& c, const Four& mean, const Four& log_std) {
  double log_prob = 0;
  for (int i = 0; i < 4; ++i) {
    const double variance = std::exp(2 * log_std[i]);
    log_prob +=
        -std::pow(c.action[i] - mean[i], 2) / (2 * variance) - 0.5 * std::log(2 * M_PI * variance);
  }
  const double ratio = std::exp(log_prob - c.proximal);
  const double clipped = std::max(1 - c.clip, std::min(1 + c.clip, ratio));
  return -c.weight * std::min(ratio * c.advantage, clipped * c.advantage);
}

PolicyLoss Ours(const Case& c) {
  std::array<float, 4> action{}, mean{}, log_std{}, inv_std{};
  for (int i = 0; i < 4; ++i) {
    action[i] = float(c.action[i]);
    mean[i] = float(c.mean[i]);
    log_std[i] = float(c.log_std[i]);
    inv_std[i] = 1 / std::exp(log_std[i]);
  }
  PolicySample sample;
  sample.action = action.data();
  sample.proximal_log_prob = float(c.proximal);
  sample.behaviour_weight = float(c.weight);
  sample.advantage = float(c.advantage);
  return ComputePolicyLoss(sample, mean.data(), inv_std.data(), log_std.data(), 4, float(c.clip));
}

Case Base(double proximal, double advantage, double weight) {
  return {{0.3, -1.2, 0.5, 2.0},
          {0.1, -1.0, 0.0, 1.5},
          {-0.5, -0.2, 0.3, -1.0},
          proximal,
          weight,
          advantage,
          0.2};
}

// Proximal log-probabilities that put the ratio below, inside and above the clip range.
TEST(PpoLossTest, LossAndDerivativesAgreeWithAnIndependentEvaluation) {
  for (const double proximal : {-4.3, -3.9, -3.5, -3.83}) {
    for (const double advantage : {-1.3, 0.7}) {
      for (const double weight : {1.0, 0.6}) {
        const Case c = Base(proximal, advantage, weight);
        const PolicyLoss ours = Ours(c);
        EXPECT_NEAR(ours.loss, Loss(c, c.mean, c.log_std), 2e-5);
        for (int i = 0; i < 4; ++i) {
          const double h = 1e-5;
          Four up = c.mean, down = c.mean;
          up[i] += h;
          down[i] -= h;
          EXPECT_NEAR(ours.d_mean[i], (Loss(c, up, c.log_std) - Loss(c, down, c.log_std)) / (2 * h),
                      2e-4);
          up = down = c.log_std;
          up[i] += h;
          down[i] -= h;
          EXPECT_NEAR(ours.d_log_std[i], (Loss(c, c.mean, up) - Loss(c, c.mean, down)) / (2 * h),
                      2e-4);
        }
      }
    }
  }
}

TEST(PpoLossTest, SaysWhetherTheRatioLeftTheClipRange) {
  double log_prob = 0;
  const Case c = Base(0, 1, 1);
  for (int i = 0; i < 4; ++i) {
    log_prob += -std::pow(c.action[i] - c.mean[i], 2) / (2 * std::exp(2 * c.log_std[i])) -
                c.log_std[i] - 0.5 * std::log(2 * M_PI);
  }
  EXPECT_FALSE(Ours(Base(log_prob, 1, 1)).clipped);
  EXPECT_FALSE(Ours(Base(log_prob - std::log(1.19), 1, 1)).clipped);
  EXPECT_TRUE(Ours(Base(log_prob - std::log(1.21), 1, 1)).clipped);
  EXPECT_TRUE(Ours(Base(log_prob - std::log(0.79), 1, 1)).clipped);
  EXPECT_NEAR(Ours(Base(log_prob - 0.1, 1, 1)).log_ratio, 0.1, 1e-5);
}

}  // namespace
}  // namespace metronome::ppo
