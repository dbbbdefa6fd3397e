#include "common/dds/learner_sightings.h"

namespace metronome::dds {

LearnerSightings::LearnerSightings(Participant* participant, WriterWatch* watch)
    : participant_(participant), watch_(watch), reader_(participant, kRunDescriptionTopic, watch) {}

std::optional<LearnerSightings::Event> LearnerSightings::Next() {
  while (auto taken = reader_.Take()) {
    if (!participant_->Owns(taken->writer)) return Open(*std::move(taken));
  }
  if (const auto id = watch_->NextLost()) return LearnerGone{*id};
  if (watch_->TakeIncompatible()) return reader_.Incompatible();
  return std::nullopt;
}

LearnerSightings::Event LearnerSightings::Open(Taken<RunDescription> taken) {
  if (taken.foreign_version) {
    RunDescription foreign;
    foreign.protocol_version = taken.header.protocol_version;
    foreign.incarnation = taken.header.incarnation;
    foreign.learner_id = taken.header.id;
    taken.content = foreign;
  }
  if (auto* bad = std::get_if<BadSample>(&taken.content)) return *bad;
  const auto& description = std::get<RunDescription>(taken.content);
  watch_->Saw(taken.writer, description.learner_id);
  return description;
}

}  // namespace metronome::dds
