#include "learner/follow.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <deque>
#include <sstream>
#include <stdexcept>

#include "learner/exit_codes.h"
#include "tests/integration/dds_fixture.h"

namespace metronome {
namespace {

constexpr FollowOptions kFollowing{true, true};

/// What is heard, in this order; std::nullopt is a deadline.
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
  EXPECT_EQ(ending.code, kExitFinished);
  EXPECT_EQ(ending.shown, 2U);
}

TEST(FollowTest, ALearnerThatIsLostWhileItIsFollowedEndsIt) {
  EXPECT_EQ(Show(ScriptedBus({StatusOf(1, 1), std::nullopt, LearnerLost{1}})).code, kExitNoLearner);
}

// It is not said twice that a learner is gone.
TEST(FollowTest, ALearnerThatIsLostBeforeItIsFollowedEndsIt) {
  const ScriptedBus lost({StatusOf(1, 1), LearnerLost{1}, std::nullopt});
  const Ending ending = Show(lost);
  EXPECT_EQ(ending.code, kExitNoLearner);
  EXPECT_EQ(ending.shown, 1U);
  EXPECT_EQ(Show(lost, {true, false}).code, kExitFinished) << "it was heard";
}

TEST(FollowTest, ALearnerThatIsHeardAgainIsNotLost) {
  EXPECT_EQ(Show(ScriptedBus({StatusOf(1, 1), LearnerLost{1}, StatusOf(1, 1), std::nullopt,
                              StatusOf(1, 1, LearnerStatus::State::kStopped)}))
                .code,
            kExitFinished);
}

TEST(FollowTest, ALearnerThatSaidItsLastWordsIsNotLost) {
  EXPECT_EQ(Show(ScriptedBus({StatusOf(1, 1, LearnerStatus::State::kStopped), LearnerLost{1},
                              std::nullopt}))
                .code,
            kExitFinished);
}

}  // namespace
}  // namespace metronome
