#include "learner/sac/schedules.h"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/unit/support/synthetic_run.h"

namespace metronome::sac {
namespace {

using testing::SmallSacConfig;

TEST(SacSchedulesTest, GradientStepsAreDueByTheRatioAfterTheRandomEpisodes) {
  RunConfig config = SmallSacConfig();  // 400 random steps, batches of 60
  config.mutable_sac()->set_replay_ratio(0.2);
  EXPECT_EQ(GradientStepsDue(400, config), 0U);
  EXPECT_EQ(GradientStepsDue(800, config), 1U);  // of 1.33: the rest waits
  EXPECT_EQ(GradientStepsDue(1200, config), 2U);
  EXPECT_EQ(GradientStepsDue(1600, config), 4U);
}

TEST(SacSchedulesTest, LearningRatesFallLinearlyToTheFloor) {
  RunConfig config = SmallSacConfig();
  SacConfig& sac = *config.mutable_sac();
  config.set_total_steps(60400);
  sac.set_replay_ratio(1);  // 1000 gradient steps
  sac.set_learning_rate_floor(0);
  EXPECT_DOUBLE_EQ(LearningRateShare(0, config), 1);
  EXPECT_DOUBLE_EQ(LearningRateShare(250, config), 0.75);
  EXPECT_DOUBLE_EQ(LearningRateShare(1001, config),
                   0);  // an update that goes beyond the run's length
  sac.set_learning_rate_floor(0.5);
  EXPECT_DOUBLE_EQ(LearningRateShare(400, config), 0.6);
  EXPECT_DOUBLE_EQ(LearningRateShare(999, config), 0.5);
  sac.set_learning_rate_floor(1);
  EXPECT_DOUBLE_EQ(LearningRateShare(999, config), 1);
}

TEST(SacSchedulesTest, TheTargetStdFallsByOneFactorAStepAndStays) {
  RunConfig config = SmallSacConfig();
  SacConfig& sac = *config.mutable_sac();
  config.set_total_steps(60400);
  sac.set_replay_ratio(1);  // 1000 gradient steps
  sac.set_target_std(0.4);
  sac.set_final_target_std(0.1);
  sac.set_target_std_decay(0.5);
  EXPECT_DOUBLE_EQ(std::exp(TargetLogStd(0, config)), 0.4);
  EXPECT_DOUBLE_EQ(std::exp(TargetLogStd(250, config)), 0.2);
  EXPECT_DOUBLE_EQ(std::exp(TargetLogStd(500, config)), 0.1);
  EXPECT_DOUBLE_EQ(std::exp(TargetLogStd(999, config)), 0.1);
  sac.set_target_std_decay(0);
  EXPECT_DOUBLE_EQ(std::exp(TargetLogStd(999, config)), 0.4);
}

}  // namespace
}  // namespace metronome::sac
