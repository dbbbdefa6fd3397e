#include "learner/network/running_statistics.h"

#include <gtest/gtest.h>

#include <cmath>
#include <stdexcept>
#include <vector>

namespace metronome::network {
namespace {

TEST(RunningStatisticsTest, MergingInPartsEqualsTheMomentsOfTheWhole) {
  const std::vector<float> values = {1, 10, 4, 20, -2, 35, 8, 5, 7, -100};  // five rows of two
  policy::RunningStatistics statistics;
  Merge(statistics, values.data(), 2, 2, 2);
  Merge(statistics, values.data() + 4, 3, 2, 2);
  EXPECT_EQ(statistics.count, 5);
  EXPECT_NEAR(statistics.mean[0], 18.0 / 5, 1e-12);
  EXPECT_NEAR(statistics.mean[1], -30.0 / 5, 1e-12);
  // Variances by hand: E[x^2] - mean^2.
  EXPECT_NEAR(StandardDeviation(statistics, 0), std::sqrt(134.0 / 5 - 3.6 * 3.6), 1e-12);
  EXPECT_NEAR(StandardDeviation(statistics, 1), std::sqrt(11750.0 / 5 - 36.0), 1e-12);
}

// By hand: 0 and 2 (mean 1, sum of squares 2) count half, 4 and 8 wholly: mean (1 + 12) / 3, and
// E[x^2] = (2 + 80) / 3.
TEST(RunningStatisticsTest, WhatHasDecayedCountsLess) {
  const std::vector<float> values = {0, 2, 4, 8};
  policy::RunningStatistics statistics;
  Merge(statistics, values.data(), 2, 1, 1);
  Decay(statistics, 0.5);
  EXPECT_EQ(StandardDeviation(statistics, 0), 1);
  Merge(statistics, values.data() + 2, 2, 1, 1);
  EXPECT_EQ(statistics.count, 3);
  EXPECT_NEAR(statistics.mean[0], 13.0 / 3, 1e-12);
  EXPECT_NEAR(StandardDeviation(statistics, 0), std::sqrt(82.0 / 3 - 169.0 / 9), 1e-12);
}

TEST(RunningStatisticsTest, TheStrideSkipsWhatLiesBetween) {
  const std::vector<float> values = {1, 99, 3, 99};
  policy::RunningStatistics statistics;
  Merge(statistics, values.data(), 2, 1, 2);
  EXPECT_EQ(statistics.mean[0], 2);
}

TEST(RunningStatisticsTest, AConstantDimensionHasNoSpreadAtAll) {
  const std::vector<float> values(1000, 0.1F);
  policy::RunningStatistics statistics;
  for (int i = 0; i < 5; ++i) Merge(statistics, values.data(), values.size(), 1, 1);
  EXPECT_LT(StandardDeviation(statistics, 0), 1e-12);
}

TEST(RunningStatisticsTest, EmptyStatisticsHaveUnitSpreadAndRefuseAnotherDimension) {
  policy::RunningStatistics statistics;
  EXPECT_EQ(StandardDeviation(statistics, 0), 1);
  const std::vector<float> values(6, 1.0F);
  Merge(statistics, values.data(), 3, 2, 2);
  EXPECT_THROW(Merge(statistics, values.data(), 2, 3, 3), std::invalid_argument);
}

}  // namespace
}  // namespace metronome::network
