#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "common/messages/episode.h"
#include "common/messages/learner_status.h"

/// The messages between learner and actors, free of any middleware. idl/ has the wire types.
namespace metronome {

/// Grows whenever wire types or the meaning of a message change. Peers of another version are
/// refused, both versions named. 2: the configuration names the heads' schedule. 3: and the
/// correlation of exploration noise. 4: and describes the environment, whose sizes are the
/// episodes'. 6: several tasks, each with statistics and a status of its own.
inline constexpr std::uint32_t kProtocolVersion = 6;

/// Learner to all: everything an actor needs to know. The newest incarnation rules.
struct RunDescription {
  std::uint32_t protocol_version = kProtocolVersion;
  std::uint64_t learner_id = 0;   // random per process; ties between learners go to the lower
  std::uint64_t incarnation = 0;  // a counter in the run's folder, grows at each start
  std::string run_name;
  std::string engine;     // e.g. "mujoco-2.2.2"
  std::string build;      // build identity of the learner
  std::string config;     // serialised RunConfig (resolved)
  bool serving = false;   // false while a starting learner still looks for rivals
  bool finished = false;  // actors end with exit 0 (unless --stay)
  bool operator==(const RunDescription&) const = default;
};

/// Learner to actors: one version of the policy (critic excluded: actors compute no values).
struct PolicySnapshot {
  std::uint64_t incarnation = 0;
  std::uint64_t version = 0;
  std::vector<float> parameters;        // actor part, ActorLayout order (common/policy/network.h)
  std::vector<float> observation_mean;  // [O], as observations
  std::vector<float> observation_inv_std;  // [O]
  bool operator==(const PolicySnapshot&) const = default;
};

/// Learner to one actor.
struct EpisodeAssignment {
  enum class Kind : std::uint8_t { kRun = 0, kRefuse = 1 };
  std::uint64_t incarnation = 0;
  std::uint64_t actor_id = 0;
  Kind kind = Kind::kRun;
  std::uint64_t weights_version = 0;   // of kRun
  std::vector<std::uint64_t> numbers;  // of kRun, in the order to play them
  std::string reason;                  // of kRefuse: shown to the user, actor exits non-zero
  bool operator==(const EpisodeAssignment&) const = default;
};

/// Actor to learner.
struct EpisodeMessage {
  std::uint64_t incarnation = 0;  // of the assignment that it answers
  std::uint64_t actor_id = 0;
  Episode episode;
};

/// Actor to learner: sent at joining, on change and once a second.
struct ActorStatus {
  std::uint32_t protocol_version = kProtocolVersion;
  std::uint64_t actor_id = 0;     // random per process
  std::uint64_t incarnation = 0;  // the learner it obeys
  std::string host;
  std::uint32_t pid = 0;
  std::string engine;
  std::string build;
  std::string canonical_digest;  // of the run's task: actor/play/canonical_episode.h
  std::uint32_t envs = 0;        // episodes it plays at once
  std::uint64_t episodes_done = 0;
  double steps_per_second = 0;  // wall-clock: shown, never used
  // Not sent: the host as the receiver's middleware knows it, whatever the actor calls itself.
  std::string vouched_host;
  bool operator==(const ActorStatus&) const = default;
};

/// Of an actor's name "host:process".
std::string HostOfName(const std::string& name);

}  // namespace metronome
