#include "common/dds/learner_sightings.h"

namespace metronome::dds {

LearnerSightings::LearnerSightings(Participant* participant, WriterWatch* watch)
    : participant_(participant), watch_(watch), reader_(participant, kRunDescriptionTopic, watch) {}

std::optional<LearnerSightings::Event> LearnerSightings::Next() {
  if (const auto id = watch_->NextLost()) return LearnerGone{*id};
  while (auto taken = reader_.Take()) {
    if (participant_->Owns(taken->writer)) continue;
    if (auto event = Open(*std::move(taken))) return event;
  }
  return std::nullopt;
}

std::optional<LearnerSightings::Event> LearnerSightings::Open(Taken<RunDescription> taken) {
  if (taken.foreign_version) {
    RunDescription foreign;
    foreign.protocol_version = taken.header.protocol_version;
    foreign.incarnation = taken.header.incarnation;
    foreign.learner_id = taken.header.id;
    taken.content = foreign;
  }
  if (auto* bad = std::get_if<BadSample>(&taken.content)) return *bad;
  const auto& description = std::get<RunDescription>(taken.content);
  if (!watch_->Saw(taken.writer, description.learner_id)) return std::nullopt;
  return description;
}

}  // namespace metronome::dds
