#include <gtest/gtest.h>
#include <mujoco/mujoco.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <memory>
#include <stdexcept>
#include <thread>
#include <vector>

#include "actor/metaworld/assets.h"
#include "actor/metaworld/engine/engine.h"
#include "actor/metaworld/placement.h"
#include "actor/metaworld/sawyer.h"
#include "actor/metaworld/tasks/environments.h"
#include "actor/metaworld/tasks/task_table.h"
#include "actor/play/canonical_episode.h"
#include "tests/parity/tasks.h"

namespace metronome::metaworld {
namespace {

using Bits = std::vector<double>;  // compared byte by byte

bool SameBits(const Bits& a, const Bits& b) {
  return a.size() == b.size() && std::memcmp(a.data(), b.data(), a.size() * sizeof(double)) == 0;
}

RandVec Placement(const TaskSpec& task, std::uint64_t number) {
  numbers::RandomStream stream(numbers::RandomPurpose::kEvaluate, 11, number,
                               numbers::kPlacementDraw);
  return DrawPlacement(task, stream);
}

/// Smoothly changing actions that press the hand down among the objects, beyond the limits at
/// times.
Action ActionAt(std::uint64_t episode, int t) {
  numbers::RandomStream stream(numbers::RandomPurpose::kEvaluate, 12, episode,
                               static_cast<std::uint64_t>(t / 10));
  Action action{};
  for (float& component : action) component = static_cast<float>(1.5 * stream.Normal());
  action[2] -= t < 60 ? 0.8F : 0.0F;
  return action;
}

void Append(const Observation& observation, Bits& bits) {
  bits.insert(bits.end(), observation.begin(), observation.end());
}

/// Everything that `steps` steps return after a reset that gave `first`.
Bits Play(SawyerEnvironment& environment, const Observation& first, std::uint64_t episode,
          int steps) {
  Bits bits;
  Append(first, bits);
  for (int t = 0; t < steps; ++t) {
    const StepResult result = environment.Step(ActionAt(episode, t));
    Append(result.observation, bits);
    bits.push_back(result.reward);
    bits.push_back(result.info.grasp_reward);
  }
  return bits;
}

class EnvironmentTest : public testing::TestWithParam<std::string> {
 protected:
  [[nodiscard]] std::unique_ptr<SawyerEnvironment> Make(bool goal_visible = true) const {
    return metaworld::tasks::MakeSawyerEnvironment(GetParam(),
                                                   {.goal_visible = goal_visible, .assets = ""});
  }
  [[nodiscard]] RandVec Place(std::uint64_t number) const { return Placement(task_, number); }

  const TaskSpec& task_ = metaworld::tasks::FindTask(GetParam());
};

TEST_P(EnvironmentTest, AnEpisodeDoesNotDependOnWhatWasPlayedBefore) {
  const auto fresh = Make();
  const Bits want = Play(*fresh, fresh->Reset(Place(1)), 1, 100);
  const auto used = Make();
  Play(*used, used->Reset(Place(2)), 2, 73);
  used->Reset(Place(3));
  const Bits got = Play(*used, used->Reset(Place(1)), 1, 100);
  EXPECT_TRUE(SameBits(got, want));
  EXPECT_FALSE(SameBits(Play(*used, used->Reset(Place(4)), 1, 100), want));
}

TEST_P(EnvironmentTest, TheSharedStateAfterHandInitialisationIsTheOneOfEveryPlacement) {
  const auto shared = Make(), afresh = Make();
  std::vector<RandVec> placements = {task_.low, task_.high};
  for (std::uint64_t number = 0; number < 10; ++number) placements.push_back(Place(number));
  for (const RandVec& placement : placements)
    EXPECT_TRUE(SameBits(Play(*shared, shared->Reset(placement), 5, 40),
                         Play(*afresh, afresh->ResetAfresh(placement), 5, 40)));
}

TEST_P(EnvironmentTest, APlacementOutsideTheBoxStartsAsAnyOther) {
  RandVec placement = Place(1);
  placement[3] += 1e-3 + task_.high[3] - task_.low[3];
  const auto shared = Make(), afresh = Make();
  shared->Reset(Place(2));
  EXPECT_TRUE(SameBits(Play(*shared, shared->Reset(placement), 5, 20),
                       Play(*afresh, afresh->ResetAfresh(placement), 5, 20)));
}

TEST_P(EnvironmentTest, ManyThreadsGiveTheBitsOfOne) {
  constexpr int kEpisodes = 6;
  std::vector<Bits> want(kEpisodes), got(kEpisodes);
  const auto play = [this](int episode, std::vector<Bits>& into) {
    const auto environment = Make();
    into[episode] = Play(*environment, environment->Reset(Place(episode)), episode, 60);
  };
  for (int i = 0; i < kEpisodes; ++i) play(i, want);
  std::vector<std::thread> threads;
  threads.reserve(kEpisodes);
  for (int i = 0; i < kEpisodes; ++i) threads.emplace_back(play, i, std::ref(got));
  for (std::thread& thread : threads) thread.join();
  for (int i = 0; i < kEpisodes; ++i) EXPECT_TRUE(SameBits(got[i], want[i])) << "episode " << i;
}

TEST_P(EnvironmentTest, AHiddenGoalReadsZeroAndChangesNothingElse) {
  const auto visible = Make(true), hidden = Make(false);
  Observation want = visible->Reset(Place(1)), got = hidden->Reset(Place(1));
  for (int t = 0; t < 50; ++t) {
    EXPECT_NE(want[36] * want[36] + want[37] * want[37], 0);
    for (int i = 36; i < kObservationSize; ++i) want[i] = 0;
    ASSERT_EQ(got, want) << "t = " << t;
    const StepResult a = visible->Step(ActionAt(1, t)), b = hidden->Step(ActionAt(1, t));
    EXPECT_EQ(a.reward, b.reward);
    want = a.observation;
    got = b.observation;
  }
}

TEST_P(EnvironmentTest, TheTimeLimitTruncatesExactlyStep500) {
  const auto environment = Make();
  EXPECT_THROW(environment->Step({}), std::logic_error) << "before the first reset";
  environment->Reset(Place(1));
  for (int t = 1; t <= 500; ++t) ASSERT_EQ(environment->Step({}).truncated, t == 500) << t;
  EXPECT_THROW(environment->Step({}), std::logic_error);
  environment->Reset(Place(1));
  EXPECT_FALSE(environment->Step({}).truncated);
}

TEST_P(EnvironmentTest, ObservationsStackTheFrameBefore) {
  const auto environment = Make();
  Observation before = environment->Reset(Place(1));
  EXPECT_TRUE(std::equal(before.begin(), before.begin() + 18, before.begin() + 18));
  for (int t = 0; t < 20; ++t) {
    const Observation now = environment->Step(ActionAt(1, t)).observation;
    EXPECT_TRUE(std::equal(before.begin(), before.begin() + 18, now.begin() + 18)) << t;
    before = now;
  }
}

TEST_P(EnvironmentTest, TheCanonicalDigestIsAFunctionOfTheTask) {
  const environment::EnvironmentRegistry registry(metaworld::tasks::Environments());
  const std::string digest = play::CanonicalDigest(registry, GetParam());
  EXPECT_EQ(digest.size(), 128U) << "the environment's, then the policy's";
  EXPECT_EQ(play::CanonicalDigest(registry, GetParam() + "-v3"), digest);
  const std::string other =
      play::CanonicalDigest(registry, GetParam() == "push" ? "assembly" : "push");
  EXPECT_NE(other.substr(0, 64), digest.substr(0, 64));
  EXPECT_EQ(other.substr(64), digest.substr(64)) << "one policy for all tasks";
}

TEST_P(EnvironmentTest, AnActionThatIsNotFiniteIsRefused) {
  const auto environment = Make();
  environment->Reset(Place(1));
  EXPECT_THROW(environment->Step({0, std::nanf(""), 0, 0}), std::invalid_argument);
  EXPECT_THROW(environment->Step({0, 0, 0, HUGE_VALF}), std::invalid_argument);
}

INSTANTIATE_TEST_SUITE_P(Tasks, EnvironmentTest, EachTask(), TestName);

TEST(EngineTest, MissingScenesNameTheFileAndTheRemedy) {
  try {
    metaworld::tasks::MakeSawyerEnvironment("push",
                                            {.goal_visible = true, .assets = "/nowhere/assets"});
    FAIL() << "no exception";
  } catch (const std::runtime_error& error) {
    const std::string message = error.what();
    EXPECT_NE(message.find("/nowhere/assets/sawyer_xyz/sawyer_push_v3.xml"), std::string::npos);
    EXPECT_NE(message.find("deploy/setup"), std::string::npos) << message;
  }
}

/// A folder like the official one, of links, but for one file.
class OtherScenes {
 public:
  explicit OtherScenes(const std::filesystem::path& but) {
    const std::filesystem::path official = DefaultAssetsPath();
    for (const auto& entry : std::filesystem::recursive_directory_iterator(
             official, std::filesystem::directory_options::follow_directory_symlink)) {
      const auto relative = std::filesystem::relative(entry.path(), official);
      const auto here = folder_ / relative;
      if (entry.is_directory())
        std::filesystem::create_directories(here);
      else if (relative != but)
        std::filesystem::create_symlink(std::filesystem::canonical(entry.path()), here);
      else
        std::filesystem::copy_file(entry.path(), here);
    }
  }
  ~OtherScenes() { std::filesystem::remove_all(folder_); }
  OtherScenes(const OtherScenes&) = delete;
  OtherScenes& operator=(const OtherScenes&) = delete;

  [[nodiscard]] const std::filesystem::path& folder() const { return folder_; }

 private:
  const std::filesystem::path folder_ =
      std::filesystem::temp_directory_path() / ("metronome_scenes_" + std::to_string(::getpid()));
};

TEST(EngineTest, AnotherSceneFileOrNoneIsNamedWithTheRemedy) {
  const std::string file = "sawyer_xyz/sawyer_push_v3.xml";
  const OtherScenes scenes(file);
  const auto refusal = [&scenes](const std::string& task) -> std::string {
    try {
      metaworld::tasks::MakeSawyerEnvironment(
          task, {.goal_visible = true, .assets = scenes.folder().string()});
    } catch (const std::runtime_error& error) {
      return error.what();
    }
    return "none";
  };
  std::ofstream(scenes.folder() / file, std::ios::app) << "<!-- changed -->";
  const std::string path = (scenes.folder() / file).string();
  EXPECT_EQ(refusal("push"), "scene file " + path +
                                 " is not that of Meta-World 3.1.1: remove the folder " +
                                 scenes.folder().string() + " and run deploy/setup");
  std::filesystem::remove(scenes.folder() / file);
  EXPECT_EQ(refusal("reach").find("scene file " + path + " is missing"), 0U) << "another's scene";
}

TEST(EngineTest, AnErrorInsideMuJoCoIsAnException) {
  const auto scene =
      metaworld::engine::Scene::Load(DefaultAssetsPath(), metaworld::tasks::FindTask("push").scene);
  metaworld::engine::PlacedModel model(scene->model());
  const metaworld::engine::DataPtr data = scene->MakeData();
  model->opt.integrator = 99;
  EXPECT_THROW(mj_step(model.get(), data.get()), metaworld::engine::EngineError);
  model->opt.integrator = mjINT_EULER;
  const metaworld::engine::DataPtr other = scene->MakeData();
  EXPECT_NO_THROW(mj_step(model.get(), other.get())) << "the process lives on";
}

TEST(EngineTest, AWarningOfMuJoCoLeavesNoFile) {
  const std::filesystem::path file = "MUJOCO_LOG.TXT";
  std::filesystem::remove(file);
  const auto scene =
      metaworld::engine::Scene::Load(DefaultAssetsPath(), metaworld::tasks::FindTask("push").scene);
  metaworld::engine::PlacedModel model(scene->model());
  const metaworld::engine::DataPtr data = scene->MakeData();
  data->qpos[0] = std::nan("");
  mj_step(model.get(), data.get());
  EXPECT_EQ(data->warning[mjWARN_BADQPOS].number, 1) << "no warning was provoked";
  EXPECT_FALSE(std::filesystem::exists(file));
}

}  // namespace
}  // namespace metronome::metaworld
