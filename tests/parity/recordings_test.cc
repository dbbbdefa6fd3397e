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
constexpr std::size_t kHorizon = 150;                  // that the tolerances speak of

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

void CopyPreviousFrame(const metaworld::Observation& from, metaworld::Observation& to) {
  std::copy_n(from.begin() + metaworld::kFrameSize, metaworld::kFrameSize,
              to.begin() + metaworld::kFrameSize);
}

void ExpectSameInfo(const metaworld::StepInfo& got, const metaworld::StepInfo& want,
                    double tolerance, bool success_by_force) {
  EXPECT_NEAR(got.near_object, want.near_object, tolerance);
  EXPECT_NEAR(got.grasp_reward, want.grasp_reward, tolerance);
  EXPECT_NEAR(got.in_place_reward, want.in_place_reward, tolerance);
  EXPECT_NEAR(got.obj_to_target, want.obj_to_target, tolerance);
  // Of contact forces, which differ between engines; stick-push's success needs them, too.
  if (kSameEngine) {
    EXPECT_EQ(got.grasp_success, want.grasp_success);
  }
  if (kSameEngine || !success_by_force) {
    EXPECT_EQ(got.success, want.success);
  }
}

void ExpectSameSteps(const replay::Trace& trace, const replay::Recording& recording,
                     double observation_tolerance, double reward_tolerance) {
  ASSERT_EQ(trace.steps.size(), recording.steps.size());
  int compared = 0;
  for (std::size_t t = 0; t < trace.steps.size(); ++t) {
    if (!recording.steps[t].returned) continue;
    ++compared;
    SCOPED_TRACE("step " + std::to_string(t + 1));
    ASSERT_TRUE(trace.steps[t].has_value());
    metaworld::StepResult got = *trace.steps[t];
    const metaworld::StepResult& want = *recording.steps[t].returned;
    // A forced replay shows the frame of the last recorded state as the previous one.
    if (t > 0 && !trace.steps[t - 1]) CopyPreviousFrame(want.observation, got.observation);
    ASSERT_LE(Distance(got.observation, want.observation), observation_tolerance);
    ASSERT_NEAR(got.reward, want.reward, reward_tolerance);
    EXPECT_EQ(got.truncated, want.truncated);
    ExpectSameInfo(got.info, want.info, reward_tolerance, recording.task == "stick-push-v3");
  }
  EXPECT_GE(compared, 10);
}

/// How far another convex collision detector may lead astray by step kHorizon, metres.
struct Drift {
  double hand;    // at that step
  double object;  // median over the recorded steps until then
};

void ExpectNear(const replay::Trace& trace, const replay::Recording& recording, Drift most) {
  std::vector<double> object;
  for (std::size_t t = 0; t < kHorizon; ++t) {
    if (!recording.steps[t].returned) continue;
    object.push_back(
        Distance(trace.steps[t]->observation, recording.steps[t].returned->observation, 4, 7));
  }
  const auto median = object.begin() + static_cast<std::ptrdiff_t>(object.size() / 2);
  std::nth_element(object.begin(), median, object.end());
  EXPECT_LE(*median, most.object) << "median distance of the object, metres";
  EXPECT_LE(Distance(trace.steps[kHorizon - 1]->observation,
                     recording.steps[kHorizon - 1].returned->observation, 0, 3),
            most.hand)
      << "distance of the hand, metres";
}

/// The reset on an engine where objects settle otherwise.
void ExpectNearAtReset(const metaworld::Observation& got, const metaworld::Observation& want) {
  EXPECT_LE(Distance(got, want, 0, 4), 1e-6) << "hand";
  EXPECT_LE(Distance(got, want, 4, 7), 1e-3) << "object";
  EXPECT_LE(Distance(got, want, 7, 11), 5e-2) << "its quaternion";
  EXPECT_LE(Distance(got, want, 11, 18), 1e-9) << "second object";
  EXPECT_LE(Distance(got, want, 36, 39), 1e-3) << "goal";
}

class RecordingTest : public testing::TestWithParam<std::string> {
 protected:
  void SetUp() override { recording_ = replay::ReadRecording(GetParam()); }
  /// Whether no contact by the convex collision detector rules the episode.
  [[nodiscard]] bool OfSimpleContacts() const {
    return recording_.task == "assembly-v3" || recording_.task == "bin-picking-v3";
  }
  [[nodiscard]] Drift MostDrift() const {
    const bool of_paper = recording_.task == "push-v3" || recording_.task == "box-close-v3";
    return of_paper ? Drift{2e-2, 1e-2} : Drift{1e-1, 5e-2};
  }
  replay::Recording recording_;
};

TEST_P(RecordingTest, ForcedReplayGivesTheRecordedObservationsAndRewards) {
  const replay::Trace trace = replay::PlayRecording(recording_, replay::TraceMode::kForced, "");
  ExpectSameSteps(trace, recording_, 1e-9, 2e-6);
}

TEST_P(RecordingTest, ResetGivesTheRecordedObservation) {
  const replay::Trace trace = replay::PlayRecording(recording_, replay::TraceMode::kForced, "");
  if (kSameEngine || OfSimpleContacts())
    EXPECT_LE(Distance(trace.reset, recording_.start.observation), 1e-9);
  else
    ExpectNearAtReset(trace.reset, recording_.start.observation);
}

TEST_P(RecordingTest, FreeReplayStaysOnTheTrajectoryAsFarAsTheEnginesAgree) {
  const replay::Trace trace = replay::PlayRecording(recording_, replay::TraceMode::kFree, "");
  if (kSameEngine)
    ExpectSameSteps(trace, recording_, 1e-9, 2e-6);
  else if (OfSimpleContacts())
    ExpectSameSteps(trace, recording_, 1e-6, 1e-5);
  else
    ExpectNear(trace, recording_, MostDrift());
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
