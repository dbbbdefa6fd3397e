#include <gtest/gtest.h>
#include <spawn.h>
#include <sys/wait.h>

#include <csignal>
#include <string>
#include <variant>
#include <vector>

#include "common/dds/dds_bus.h"
#include "tests/integration/dds_fixture.h"

extern char** environ;

namespace metronome::test {
namespace {

/// A dds_peer process; killed at the end at the latest.
class Peer {
 public:
  Peer(const BusOptions& options, std::uint64_t actor_id) {
    std::vector<std::string> words = {DDS_PEER, options.run_name, std::to_string(options.domain),
                                      options.transport == Transport::kUdp ? "udp" : "shm",
                                      std::to_string(actor_id)};
    std::vector<char*> arguments(words.size() + 1, nullptr);
    for (std::size_t i = 0; i < words.size(); ++i) arguments[i] = words[i].data();
    if (posix_spawn(&pid_, DDS_PEER, nullptr, nullptr, arguments.data(), environ) != 0) pid_ = -1;
  }
  ~Peer() { Kill(); }
  Peer(const Peer&) = delete;
  Peer& operator=(const Peer&) = delete;

  [[nodiscard]] bool started() const { return pid_ > 0; }
  void Signal(int number) const { kill(pid_, number); }
  void Kill() {
    if (pid_ <= 0) return;
    Signal(SIGKILL);
    waitpid(pid_, nullptr, 0);
    pid_ = -1;
  }

 private:
  pid_t pid_ = -1;
};

/// Retries at every event: the actor's assignment reader may be matched a moment after its status
/// writer.
bool SendWhenReachable(LearnerBus& learner, const EpisodeAssignment& assignment) {
  for (const Clock::time_point deadline = Soon(); Clock::now() < deadline;) {
    if (learner.Send(assignment)) return true;
    (void)learner.Wait(deadline);
  }
  return false;
}

/// Assigns the number at each status of the actor until its episode comes. An actor that was
/// stopped joins anew, by another participant: what the learner sent to the one before is lost with
/// it (and assigned again, AssignmentPlan::GiveUpLost).
bool AnswersInTheEnd(LearnerBus& learner, std::uint64_t actor_id, std::uint64_t number) {
  const Clock::time_point deadline = Soon();
  while (const auto event = learner.Wait(deadline)) {
    const auto* episode = std::get_if<EpisodeMessage>(&*event);
    if (episode != nullptr && episode->episode.number == number) return true;
    if (std::holds_alternative<ActorStatus>(*event)) {
      (void)learner.Send(SomeAssignment(actor_id, number));
    }
  }
  return false;
}

class DdsFaultsTest : public testing::TestWithParam<Transport> {};

TEST_P(DdsFaultsTest, KilledActorIsNoticedWithinSecondsAndItsSuccessorIsHeard) {
  const BusOptions options = FreshRun(GetParam());
  const auto learner = ServingLearner(options);
  for (std::uint64_t id = 1; id <= 2; ++id) {
    Peer peer(options, id);
    ASSERT_TRUE(peer.started());
    const auto status = Next<ActorStatus>(*learner);
    ASSERT_TRUE(status) << "actor " << id;
    EXPECT_EQ(status->actor_id, id);
    ASSERT_TRUE(Next<EpisodeMessage>(*learner)) << "actor " << id;
    peer.Kill();
    const Clock::time_point killed = Clock::now();
    const auto lost = Next<ActorLost>(*learner, killed + seconds(5));
    ASSERT_TRUE(lost) << "actor " << id;
    EXPECT_EQ(lost->actor_id, id);
  }
}

TEST_P(DdsFaultsTest, SuccessorOfAKilledActorIsHeardAtOnce) {
  const BusOptions options = FreshRun(GetParam());
  const auto learner = ServingLearner(options);
  for (std::uint64_t id = 1; id <= 3; ++id) {
    Peer peer(options, id);
    std::optional<ActorStatus> status;
    do {
      status = Next<ActorStatus>(*learner);
      ASSERT_TRUE(status) << "actor " << id;
    } while (status->actor_id != id);
    ASSERT_TRUE(Next<EpisodeMessage>(*learner)) << "actor " << id;
  }
}

INSTANTIATE_TEST_SUITE_P(Transports, DdsFaultsTest,
                         testing::Values(Transport::kUdp, Transport::kSharedMemory),
                         [](const auto& test) {
                           return test.param == Transport::kUdp ? "Udp" : "SharedMemory";
                         });

TEST_P(DdsFaultsTest, OneOfSeveralIsMissedWhenItIsKilled) {
  const BusOptions options = FreshRun(GetParam());
  const auto learner = ServingLearner(options);
  Peer stays(options, 1);
  Peer dies(options, 2);
  for (bool heard[3] = {true, false, false}; !heard[1] || !heard[2];) {
    const auto status = Next<ActorStatus>(*learner);
    ASSERT_TRUE(status);
    heard[status->actor_id] = true;
  }
  dies.Kill();
  const auto lost = Next<ActorLost>(*learner, Clock::now() + seconds(5));
  ASSERT_TRUE(lost);
  EXPECT_EQ(lost->actor_id, 2);
}

TEST(DdsFaultsTest, StoppedActorIsLostAndComesBack) {
  const BusOptions options = FreshRun();
  const auto learner = ServingLearner(options);
  Peer peer(options, 7);
  ASSERT_TRUE(peer.started());
  ASSERT_TRUE(Next<ActorStatus>(*learner));
  peer.Signal(SIGSTOP);
  const auto lost = Next<ActorLost>(*learner);
  ASSERT_TRUE(lost);
  EXPECT_EQ(lost->actor_id, 7);
  EXPECT_FALSE(learner->Send(SomeAssignment(7, 0)));
  peer.Signal(SIGCONT);
  const auto back = Next<ActorStatus>(*learner);
  ASSERT_TRUE(back);
  EXPECT_EQ(back->actor_id, 7);
  EXPECT_TRUE(AnswersInTheEnd(*learner, 7, 1'000'000));
}

TEST(DdsRejoinTest, AnActorThatJoinedByANewParticipantIsNotLostWithItsOldOne) {
  const BusOptions options = FreshRun();
  const auto learner = dds::MakeDdsLearnerBus(options);
  auto old_one = dds::MakeDdsActorBus(options, 11);
  ASSERT_TRUE(Join(*learner, *old_one, 11));
  const auto new_one = dds::MakeDdsActorBus(options, 11);
  ASSERT_TRUE(Join(*learner, *new_one, 11));
  auto witness = dds::MakeDdsActorBus(options, 12);
  ASSERT_TRUE(Join(*learner, *witness, 12));
  old_one.reset();
  witness.reset();  // noticed after the other, whose farewell came first
  const auto lost = Next<ActorLost>(*learner);
  ASSERT_TRUE(lost);
  EXPECT_EQ(lost->actor_id, 12U);
  EXPECT_TRUE(SendWhenReachable(*learner, SomeAssignment(11, 7)));
  const auto assignment = Next<EpisodeAssignment>(*new_one);
  ASSERT_TRUE(assignment);
}

}  // namespace
}  // namespace metronome::test
