#include "learner/watch/follow.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <deque>
#include <nlohmann/json.hpp>
#include <sstream>
#include <stdexcept>
#include <string>
#include <vector>

#include "common/process/exit_codes.h"
#include "learner/watch/status_text.h"
#include "tests/integration/dds_fixture.h"

namespace metronome::watch {
namespace {

using ::testing::ElementsAre;

constexpr FollowOptions kFollowing{true, true};

/// Hears the events of a script one after the other; std::nullopt is a deadline.
class ScriptedBus final : public ObserverBus {
 public:
  explicit ScriptedBus(std::deque<std::optional<ObserverEvent>> script)
      : script_(std::move(script)) {}
  std::optional<ObserverEvent> Wait(Clock::time_point) override {
    if (script_.empty()) throw std::logic_error("it waits for ever");
    auto event = std::move(script_.front());
    script_.pop_front();
    return event;
  }

 private:
  std::deque<std::optional<ObserverEvent>> script_;
};

LearnerStatus StatusOf(std::uint64_t learner_id, std::uint64_t incarnation,
                       LearnerStatus::State state = LearnerStatus::State::kCollecting) {
  LearnerStatus status = test::SomeLearnerStatus(incarnation);
  status.learner_id = learner_id;
  status.state = state;
  return status;
}

struct Ending {
  std::optional<int> code;
  std::size_t shown = 0;
};

Ending Show(ScriptedBus bus, const FollowOptions& options = kFollowing) {
  std::ostringstream out;
  Ending ending;
  ending.code = ShowLearner(bus, Clock::time_point{}, options, out);
  const std::string text = out.str();
  ending.shown = static_cast<std::size_t>(std::count(text.begin(), text.end(), '\n'));
  return ending;
}

TEST(FollowTest, AnOutputThatTakesNothingMoreIsAnError) {
  ScriptedBus bus({StatusOf(1, 1), std::nullopt});
  std::ostringstream full;
  full.setstate(std::ios::badbit);
  EXPECT_THROW(ShowLearner(bus, Clock::time_point{}, kFollowing, full), std::runtime_error);
}

TEST(FollowTest, NobodyIsThere) {
  const Ending ending = Show(ScriptedBus({std::nullopt}));
  EXPECT_EQ(ending.code, std::nullopt);
  EXPECT_EQ(ending.shown, 0U);
}

TEST(FollowTest, ALearnerIsFollowedToItsEndAndLostOnesOfBeforeDoNotMatter) {
  const Ending ending =
      Show(ScriptedBus({StatusOf(1, 1), LearnerLost{1}, StatusOf(2, 2), std::nullopt,
                        LearnerLost{1}, StatusOf(2, 2, LearnerStatus::State::kFinished)}));
  EXPECT_EQ(ending.code, process::kExitFinished);
  EXPECT_EQ(ending.shown, 2U);
}

TEST(FollowTest, ALearnerThatIsLostWhileItIsFollowedEndsIt) {
  EXPECT_EQ(Show(ScriptedBus({StatusOf(1, 1), std::nullopt, LearnerLost{1}})).code,
            process::kExitNoLearner);
}

// It is not said twice that a learner is gone.
TEST(FollowTest, ALearnerThatIsLostBeforeItIsFollowedEndsIt) {
  const ScriptedBus lost({StatusOf(1, 1), LearnerLost{1}, std::nullopt});
  const Ending ending = Show(lost);
  EXPECT_EQ(ending.code, process::kExitNoLearner);
  EXPECT_EQ(ending.shown, 1U);
  EXPECT_EQ(Show(lost, {true, false}).code, process::kExitFinished) << "it was heard";
}

TEST(FollowTest, ALearnerThatIsHeardAgainIsNotLost) {
  EXPECT_EQ(Show(ScriptedBus({StatusOf(1, 1), LearnerLost{1}, StatusOf(1, 1), std::nullopt,
                              StatusOf(1, 1, LearnerStatus::State::kStopped)}))
                .code,
            process::kExitFinished);
}

TEST(FollowTest, ALearnerThatSaidItsLastWordsIsNotLost) {
  EXPECT_EQ(Show(ScriptedBus({StatusOf(1, 1, LearnerStatus::State::kStopped), LearnerLost{1},
                              std::nullopt}))
                .code,
            process::kExitFinished);
}

LearnerStatus OfAge(double seconds, LearnerStatus status) {
  status.age_seconds = seconds;
  return status;
}

/// The ages of the statuses that are shown.
std::vector<double> AgesShown(ScriptedBus bus, bool follow) {
  std::stringstream out;
  ShowLearner(bus, Clock::time_point{}, {true, follow}, out);
  std::vector<double> ages;
  for (std::string line; std::getline(out, line);) {
    ages.push_back(nlohmann::json::parse(line).at("age_seconds").get<double>());
  }
  return ages;
}

TEST(FollowTest, AnOldStatusSaysSoUnlessTheLearnerSpeaksAgain) {
  const LearnerStatus status = StatusOf(1, 1);
  EXPECT_THAT(AgesShown(ScriptedBus({OfAge(0.5, status), std::nullopt}), false), ElementsAre(0.5));
  EXPECT_THAT(AgesShown(ScriptedBus({OfAge(60, status), std::nullopt}), false), ElementsAre(60));
  EXPECT_THAT(AgesShown(ScriptedBus({OfAge(60, status), OfAge(60, status), std::nullopt}), false),
              ElementsAre(0))
      << "the two hosts' clocks differ";
  EXPECT_THAT(AgesShown(ScriptedBus({OfAge(-60, status), std::nullopt}), false),
              ElementsAre(kOldStatusSeconds))
      << "it was silent at least that long";
}

TEST(FollowTest, ASilentLearnerIsShownAgainWithItsAge) {
  const LearnerStatus status = StatusOf(1, 1);
  const auto ages = AgesShown(
      ScriptedBus({OfAge(60, status), std::nullopt, std::nullopt, StatusOf(1, 1), LearnerLost{1}}),
      true);
  ASSERT_EQ(ages.size(), 3U);
  EXPECT_EQ(ages[0], 60);
  EXPECT_GE(ages[1], 60);
  EXPECT_EQ(ages[2], 0);
}

}  // namespace
}  // namespace metronome::watch
