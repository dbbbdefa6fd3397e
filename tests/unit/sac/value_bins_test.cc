#include "learner/sac/value_bins.h"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

namespace metronome::sac {
namespace {

TEST(ValueBinsTest, SymlogAndSymexpAreInverseAndOdd) {
  for (const float x : {0.0F, 1e-3F, 0.5F, 1.0F, 35.0F, 3500.0F}) {
    EXPECT_NEAR(ValueBins::Symlog(x), std::log1p(x), 1e-6 * (1 + std::log1p(x)));
    EXPECT_NEAR(ValueBins::Symexp(ValueBins::Symlog(x)), x, 2e-6F * (1 + x) * 8);
    EXPECT_EQ(ValueBins::Symlog(-x), -ValueBins::Symlog(x));
    EXPECT_EQ(ValueBins::Symexp(-x), -ValueBins::Symexp(x));
  }
}

TEST(ValueBinsTest, ANumberIsTheMeanOfTheTwoBinsThatShareIt) {
  const ValueBins bins(21, 10);
  ASSERT_EQ(bins.size(), 21U);
  EXPECT_EQ(bins.bins().front(), -10);
  EXPECT_EQ(bins.bins()[10], 0);
  EXPECT_EQ(bins.bins().back(), 10);
  for (float x = -10; x <= 10; x += 0.37F) {
    const ValueBins::TwoHot share = bins.Share(x);
    std::vector<float> probability(21, 0.0F);
    probability[share.low] = share.of_low;
    probability[share.low + 1] = share.of_high;
    EXPECT_GE(share.of_low, 0);
    EXPECT_GE(share.of_high, 0);
    EXPECT_NEAR(share.of_low + share.of_high, 1, 1e-6);
    EXPECT_NEAR(bins.Mean(probability.data()), x, 2e-6);
  }
}

TEST(ValueBinsTest, BeyondTheLimitCountsAsTheLimit) {
  const ValueBins bins(5, 2);
  EXPECT_EQ(bins.Share(7).low, 3U);
  EXPECT_EQ(bins.Share(7).of_high, 1);
  EXPECT_EQ(bins.Share(-7).low, 0U);
  EXPECT_EQ(bins.Share(-7).of_low, 1);
}

TEST(SoftmaxTest, IsThatOfEachRowHoweverLargeItsLogits) {
  constexpr std::size_t kStride = 32;
  std::vector<float> rows(2 * kStride, 0.0F);
  for (std::size_t i = 0; i < 21; ++i) {
    rows[i] = 0.3F * float(i) - 2;
    rows[kStride + i] = 1e4F - float(i);
  }
  const std::vector<float> logits = rows;
  Softmax(rows.data(), 2, 21, kStride);
  for (std::size_t r = 0; r < 2; ++r) {
    double sum = 0;
    for (std::size_t i = 0; i < 21; ++i)
      sum += std::exp(double{logits[r * kStride + i]} - (r == 0 ? 4.0 : 1e4));
    for (std::size_t i = 0; i < 21; ++i) {
      const double want = std::exp(double{logits[r * kStride + i]} - (r == 0 ? 4.0 : 1e4)) / sum;
      EXPECT_NEAR(rows[r * kStride + i], want, 1e-6);
    }
  }
}

}  // namespace
}  // namespace metronome::sac
