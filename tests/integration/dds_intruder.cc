#include <cstdio>
#include <cstdlib>
#include <cstring>

#include "tests/integration/raw_writer.h"

namespace metronome::test {
namespace {

/// @return whether somebody reads what this process would write on the topic.
template <class PubSubType>
const char* Fate(const BusOptions& options, const dds::TopicProfile& profile) {
  try {
    RawWriter writer(options, profile, PubSubType().getName());
    const bool is_read = writer.WaitForReader(Clock::now() + std::chrono::seconds(4));
    return is_read ? "is read" : "is not read";
  } catch (const RawWriter::Forbidden&) {
    return "may not be written";
  }
}

int Try(const BusOptions& options, const char* topic) {
  const auto is = [topic](const char* name) { return std::strcmp(topic, name) == 0; };
  if (is("episode")) {
    std::puts(Fate<wire::EpisodePubSubType>(options, dds::kEpisodeTopic));
  } else if (is("run_description")) {
    std::puts(Fate<wire::RunDescriptionPubSubType>(options, dds::kRunDescriptionTopic));
  } else if (is("episode_assignment")) {
    std::puts(Fate<wire::EpisodeAssignmentPubSubType>(options, dds::kEpisodeAssignmentTopic));
  } else if (is("policy_snapshot")) {
    std::puts(Fate<wire::PolicySnapshotPubSubType>(options, dds::kPolicySnapshotTopic));
  } else {
    return 2;
  }
  return 0;
}

}  // namespace
}  // namespace metronome::test

/// A writer that takes an identity's folder as it is, without this project's own checks: says
/// whether anyone reads it. dds_intruder RUN DOMAIN FOLDER
/// episode|run_description|episode_assignment|policy_snapshot
int main(int argc, char** argv) {
  if (argc != 5) return 2;
  metronome::BusOptions options;
  options.run_name = argv[1];
  options.domain = static_cast<std::uint32_t>(std::atoi(argv[2]));
  options.security = argv[3];
  return metronome::test::Try(options, argv[4]);
}
