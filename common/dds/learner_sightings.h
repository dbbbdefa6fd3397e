#pragma once

#include <cstdint>
#include <optional>
#include <variant>

#include "common/dds/endpoints.h"

namespace metronome::dds {

/// A learner of the run is gone.
struct LearnerGone {
  std::uint64_t learner_id = 0;
};

/// The run descriptions that other processes publish, and the ends of those processes. Thread-safe
/// but for Next, which one thread at a time may call.
class LearnerSightings {
 public:
  using Event = std::variant<RunDescription, LearnerGone, BadSample>;

  /// @param watch  must outlive the participant, as its listener.
  LearnerSightings(Participant* participant, WriterWatch* watch);

  /// Never blocks. A description of another protocol version has its version, incarnation and
  /// learner id alone.
  std::optional<Event> Next();

 private:
  Event Open(Taken<RunDescription> taken);

  Participant* const participant_;
  WriterWatch* const watch_;
  Reader<wire::RunDescriptionPubSubType> reader_;
};

}  // namespace metronome::dds
