#include <gtest/gtest.h>
#include <mujoco/mujoco.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <vector>

#include "actor/replay/recording.h"
#include "actor/replay/trace.h"

/// The environment held against every recording in tests/fixtures/recordings, which the official
/// package made on MuJoCo 3.3.0. The tolerances are the reference's.
namespace metronome {
namespace {

constexpr bool kSameEngine = mjVERSION_HEADER >= 330;  // as the recordings'
constexpr int kHorizon = 150;                          // that the tolerances speak of

std::vector<std::string> RecordingFiles() {
  std::vector<std::string> files;
  for (const auto& entry : std::filesystem::directory_iterator(METRONOME_FIXTURES "/recordings"))
    files.push_back(entry.path().string());
  std::sort(files.begin(), files.end());
  return files;
}

double Distance(const metaworld::Observation& a, const metaworld::Observation& b, int from,
                int to) {
  double distance = 0;
  for (int i = from; i < to; ++i) distance = std::max(distance, std::abs(a[i] - b[i]));
  return distance;
}

double Distance(const metaworld::Observation& a, const metaworld::Observation& b) {
  return Distance(a, b, 0, metaworld::kObservationSize);
}

void ExpectSameInfo(const metaworld::StepInfo& got, const metaworld::StepInfo& want,
                    double tolerance) {
  EXPECT_EQ(got.success, want.success);
  EXPECT_NEAR(got.near_object, want.near_object, tolerance);
  EXPECT_NEAR(got.grasp_reward, want.grasp_reward, tolerance);
  EXPECT_NEAR(got.in_place_reward, want.in_place_reward, tolerance);
  EXPECT_NEAR(got.obj_to_target, want.obj_to_target, tolerance);
  // Of contact forces, which differ between engines.
  if (kSameEngine) {
    EXPECT_EQ(got.grasp_success, want.grasp_success);
  }
}

void ExpectSameSteps(const replay::Trace& trace, const replay::Recording& recording,
                     double observation_tolerance, double reward_tolerance) {
  ASSERT_EQ(trace.steps.size(), recording.steps.size());
  for (std::size_t t = 0; t < trace.steps.size(); ++t) {
    SCOPED_TRACE("step " + std::to_string(t + 1));
    const metaworld::StepResult& got = trace.steps[t];
    ASSERT_TRUE(recording.steps[t].returned.has_value());
    const metaworld::StepResult& want = *recording.steps[t].returned;
    ASSERT_LE(Distance(got.observation, want.observation), observation_tolerance);
    ASSERT_NEAR(got.reward, want.reward, reward_tolerance);
    EXPECT_EQ(got.truncated, want.truncated);
    ExpectSameInfo(got.info, want.info, reward_tolerance);
  }
}

/// The agreement that another convex collision detector leaves.
void ExpectNear(const replay::Trace& trace, const replay::Recording& recording) {
  std::vector<double> object(kHorizon);
  for (int t = 0; t < kHorizon; ++t)
    object[t] =
        Distance(trace.steps[t].observation, recording.steps[t].returned->observation, 4, 7);
  std::nth_element(object.begin(), object.begin() + kHorizon / 2, object.end());
  EXPECT_LE(object[kHorizon / 2], 1e-2) << "median distance of the object, metres";
  EXPECT_LE(Distance(trace.steps[kHorizon - 1].observation,
                     recording.steps[kHorizon - 1].returned->observation, 0, 3),
            2e-2)
      << "distance of the hand, metres";
}

class RecordingTest : public testing::TestWithParam<std::string> {
 protected:
  void SetUp() override { recording_ = replay::ReadRecording(GetParam()); }
  [[nodiscard]] bool Convex() const {  // contacts by the convex collision detector rule the object
    return recording_.task == "push-v3" || recording_.task == "box-close-v3";
  }
  replay::Recording recording_;
};

TEST_P(RecordingTest, ForcedReplayGivesTheRecordedObservationsAndRewards) {
  const replay::Trace trace = replay::PlayRecording(recording_, replay::TraceMode::kForced, "");
  ExpectSameSteps(trace, recording_, 1e-9, 2e-6);
}

TEST_P(RecordingTest, ResetGivesTheRecordedObservation) {
  const replay::Trace trace = replay::PlayRecording(recording_, replay::TraceMode::kForced, "");
  const double tolerance = kSameEngine ? 1e-9 : Convex() ? 1e-3 : 1e-9;
  EXPECT_LE(Distance(trace.reset, recording_.start.observation), tolerance);
}

TEST_P(RecordingTest, FreeReplayStaysOnTheTrajectoryAsFarAsTheEnginesAgree) {
  const replay::Trace trace = replay::PlayRecording(recording_, replay::TraceMode::kFree, "");
  if (kSameEngine)
    ExpectSameSteps(trace, recording_, 1e-9, 2e-6);
  else if (!Convex())
    ExpectSameSteps(trace, recording_, 1e-6, 1e-5);
  else
    ExpectNear(trace, recording_);
}

INSTANTIATE_TEST_SUITE_P(All, RecordingTest, testing::ValuesIn(RecordingFiles()),
                         [](const auto& file) {
                           std::string name = std::filesystem::path(file.param).filename();
                           name = name.substr(0, name.find('.'));
                           std::replace_if(
                               name.begin(), name.end(),
                               [](unsigned char c) { return std::isalnum(c) == 0; }, '_');
                           return name;
                         });

}  // namespace
}  // namespace metronome
