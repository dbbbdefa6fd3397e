#include "common/numbers/random.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <set>
#include <stdexcept>
#include <vector>

#include "tests/unit/support/bits_hash.h"

namespace metronome::numbers {
namespace {

TEST(RandomStreamTest, IsAPureFunctionOfItsKeyAndCounter) {
  RandomStream a(RandomPurpose::kTrain, 7, 11, 13);
  RandomStream b(RandomPurpose::kTrain, 7, 11, 13);
  for (int i = 0; i < 100; ++i) EXPECT_EQ(a.Bits(), b.Bits());
}

TEST(RandomStreamTest, EveryPartOfTheKeyChangesTheStream) {
  std::set<std::uint64_t> first;
  for (const auto purpose :
       {RandomPurpose::kTrain, RandomPurpose::kEvaluate, RandomPurpose::kInitialise,
        RandomPurpose::kShuffle, RandomPurpose::kHeadPermutation}) {
    for (std::uint64_t seed = 0; seed < 4; ++seed) {
      for (std::uint64_t number = 0; number < 4; ++number) {
        for (const std::uint64_t t : {std::uint64_t{0}, std::uint64_t{1}, kPlacementDraw}) {
          first.insert(RandomStream(purpose, seed, number, t).Bits());
        }
      }
    }
  }
  EXPECT_EQ(first.size(), 5U * 4U * 4U * 3U);
}

// Random123's own known-answer vector of philox4x64-10 for an all-zero key and counter would need
// purpose 0, which no stream has; this pins the stream that every run's first action uses instead.
TEST(RandomStreamTest, TheStreamsAreFrozen) {
  RandomStream stream(RandomPurpose::kTrain, 1, 0, 0);
  const std::uint64_t first = stream.Bits();
  const std::uint64_t second = stream.Bits();
  EXPECT_EQ(first, 0x66387239d96c2992U);
  EXPECT_EQ(second, 0x6e3eeb840de668faU);
}

TEST(RandomStreamTest, TheNormalsAreFrozen) {
  RandomStream stream(RandomPurpose::kTrain, 1, 0, 0);
  testing::BitsHash hash;
  for (int i = 0; i < 10000; ++i) hash.Add(stream.Normal());
  EXPECT_EQ(hash.value(), 0xa17060302cbfec0cU);
}

TEST(RandomStreamTest, UniformsAndNormalsHaveTheirMoments) {
  const int n = 200000;
  double uniform = 0;
  double normal = 0;
  double square = 0;
  RandomStream stream(RandomPurpose::kEvaluate, 3, 0, 0);
  for (int i = 0; i < n; ++i) {
    const double u = stream.Uniform();
    ASSERT_GE(u, 0);
    ASSERT_LT(u, 1);
    uniform += u / n;
    const double z = stream.Normal();
    ASSERT_TRUE(std::isfinite(z));
    normal += z / n;
    square += z * z / n;
  }
  // Five standard errors each.
  EXPECT_NEAR(uniform, 0.5, 5 * std::sqrt(1.0 / 12 / n));
  EXPECT_NEAR(normal, 0, 5 / std::sqrt(n));
  EXPECT_NEAR(square, 1, 5 * std::sqrt(2.0 / n));
}

TEST(RandomStreamTest, BelowStaysBelowAndRefusesZero) {
  RandomStream stream(RandomPurpose::kShuffle, 1, 2, 3);
  std::vector<int> seen(7, 0);
  for (int i = 0; i < 7000; ++i) ++seen.at(stream.Below(7));
  for (const int count : seen) EXPECT_NEAR(count, 1000, 150);
  EXPECT_THROW(stream.Below(0), std::invalid_argument);
}

TEST(PermutationTest, HoldsEveryIndexOnceAndDependsOnTheStream) {
  const auto a = Permutation(1000, {RandomPurpose::kShuffle, 1, 0, 0});
  const auto b = Permutation(1000, {RandomPurpose::kShuffle, 1, 0, 1});
  EXPECT_NE(a, b);
  auto sorted = a;
  std::sort(sorted.begin(), sorted.end());
  for (std::uint32_t i = 0; i < 1000; ++i) ASSERT_EQ(sorted[i], i);
}

}  // namespace
}  // namespace metronome::numbers
