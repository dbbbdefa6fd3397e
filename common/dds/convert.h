#pragma once

#include <stdexcept>

#include "common/messages/messages.h"
#include "idl/metronome.h"

/// Messages to wire types and back. Stateless and thread-safe. What carries arrays is taken by
/// value: moved in, its arrays are moved on and not copied.
namespace metronome::dds {

/// A message that does not fit the wire, or a wire sample that no correct peer sends.
class Malformed : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// @throws Malformed if a text or array exceeds its bound in idl/metronome.idl.
wire::RunDescription ToWire(const RunDescription& message);
wire::PolicySnapshot ToWire(PolicySnapshot message);
wire::EpisodeAssignment ToWire(const EpisodeAssignment& message);
wire::Episode ToWire(EpisodeMessage message);
wire::ActorStatus ToWire(const ActorStatus& message);
/// Actors beyond the bound are left out.
wire::LearnerStatus ToWire(const LearnerStatus& message);

/// The inverse: checks bounds, lengths that must agree, enumerations and the snapshot's checksum.
/// Numbers inside arrays are not judged here. @throws Malformed with the reason.
RunDescription FromWire(const wire::RunDescription& sample);
PolicySnapshot FromWire(wire::PolicySnapshot sample);
EpisodeAssignment FromWire(const wire::EpisodeAssignment& sample);
EpisodeMessage FromWire(wire::Episode sample);
ActorStatus FromWire(const wire::ActorStatus& sample);
LearnerStatus FromWire(const wire::LearnerStatus& sample);

/// CRC-32 (zlib's) of version and the three arrays, as idl/metronome.idl says.
std::uint32_t SnapshotChecksum(const PolicySnapshot& snapshot);

}  // namespace metronome::dds
