#include "learner/network/shared_heads.h"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "common/policy/network.h"
#include "tests/unit/support/synthetic_run.h"

namespace metronome::network {
namespace {

using testing::SmallConfig;

policy::NetworkShape ShapeOf(int heads) { return policy::ShapeOf(SmallConfig(MULTIHEAD, heads)); }

std::vector<float> Numbers(std::size_t count, std::uint64_t key) {
  numbers::RandomStream random(numbers::RandomPurpose::kEvaluate, key, 0, 0);
  std::vector<float> found(count);
  for (float& number : found) number = float(random.Normal());
  return found;
}

// Where a head's numbers lie, one list a network, in the order of the shared gradient.
std::vector<std::vector<std::size_t>> PlacesOf(const policy::NetworkShape& shape, int head) {
  const policy::MlpLayout actor = policy::ActorLayout(shape);
  const policy::MlpLayout critic = policy::CriticLayout(shape);
  std::vector<std::size_t> of_actor, of_critic;
  const auto add = [](std::vector<std::size_t>& places, std::size_t first, std::size_t count) {
    for (std::size_t i = 0; i < count; ++i) places.push_back(first + i);
  };
  const auto j = std::size_t(head);
  const auto inputs = std::size_t(actor.head.inputs);
  add(of_actor, actor.head.weight + j * 4 * inputs, 4 * inputs);
  add(of_actor, actor.head.bias + j * 4, 4);
  add(of_critic, actor.size + critic.head.weight + j * inputs, inputs);
  add(of_critic, actor.size + critic.head.bias + j, 1);
  return {of_actor, of_critic};
}

TEST(SharedHeadsTest, AHeadFollowsTheSumOfAllGradientsAndItsDistanceFromTheMeanFades) {
  const policy::NetworkShape shape = ShapeOf(3);
  const SharedHeads shared(shape);
  const std::size_t count = policy::ParameterCount(shape);
  const std::vector<float> gradient = Numbers(count, 1), before = Numbers(count, 2);
  std::vector<float> after = before;
  SharedHeads::Moments moments{std::vector<float>(shared.size(), 0.5F),
                               std::vector<float>(shared.size(), 0.25F)};
  AdamStep adam;
  adam.learning_rate = 1e-2F;
  adam.step = 3;
  adam.gradient_scale = 0.7F;
  shared.Step(Adam(adam), gradient.data(), 0.1F, moments, after.data());

  std::size_t at = 0;
  std::vector<bool> is_of_a_head(count, false);
  for (std::size_t network = 0; network < 2; ++network) {
    for (std::size_t i = 0; i < PlacesOf(shape, 0)[network].size(); ++i, ++at) {
      double sum = 0, mean = 0;
      for (int head = 0; head < 3; ++head) {
        const std::size_t place = PlacesOf(shape, head)[network][i];
        sum += 0.7 * gradient[place];
        mean += before[place] / 3.0;
        is_of_a_head[place] = true;
      }
      const double m = 0.9 * 0.5 + 0.1 * sum, v = 0.999 * 0.25 + 0.001 * sum * sum;
      EXPECT_NEAR(moments.m[at], m, 1e-6);
      EXPECT_NEAR(moments.v[at], v, 1e-6);
      const double step = -1e-2 * (m / (1 - std::pow(0.9, 3))) /
                          (std::sqrt(v / (1 - std::pow(0.999, 3))) + adam.epsilon);
      for (int head = 0; head < 3; ++head) {
        const std::size_t place = PlacesOf(shape, head)[network][i];
        EXPECT_NEAR(after[place], before[place] + step - 0.1 * (before[place] - mean), 1e-5);
      }
    }
  }
  EXPECT_EQ(at, shared.size());
  for (std::size_t i = 0; i < count; ++i) {
    if (is_of_a_head[i]) continue;
    EXPECT_EQ(after[i], before[i]) << "a hidden layer moved";
  }
}

TEST(SharedHeadsTest, HeadsBeginAsTheFirstOne) {
  const policy::NetworkShape shape = ShapeOf(3);
  const std::vector<float> before = Numbers(policy::ParameterCount(shape), 1);
  std::vector<float> parameters = before;
  SharedHeads(shape).MakeEqual(parameters);
  for (std::size_t network = 0; network < 2; ++network) {
    const auto first = PlacesOf(shape, 0)[network], last = PlacesOf(shape, 2)[network];
    for (std::size_t i = 0; i < first.size(); ++i) {
      EXPECT_EQ(parameters[first[i]], before[first[i]]);
      EXPECT_EQ(parameters[last[i]], before[first[i]]);
    }
  }
}

TEST(SharedHeadsTest, OneHeadSharesNothing) { EXPECT_EQ(SharedHeads(ShapeOf(1)).size(), 0U); }

TEST(SharedHeadsTest, OneCriticForAllHeadsSharesTheActorsAlone) {
  RunConfig config = SmallConfig(MULTIHEAD, 3);
  config.mutable_policy()->set_critic_heads(CRITIC_HEADS_SHARED);
  const policy::NetworkShape shape = policy::ShapeOf(config);
  EXPECT_EQ(SharedHeads(shape).size(), PlacesOf(ShapeOf(3), 0)[0].size());
}

}  // namespace
}  // namespace metronome::network
