#include <cstdio>
#include <cstdlib>
#include <cstring>

#include "tests/integration/raw_writer.h"

namespace metronome::test {
namespace {

/// @return whether somebody reads what this process would write on the topic.
template <class PubSubType>
bool IsRead(const BusOptions& options, const dds::TopicProfile& profile) {
  RawWriter writer(options, profile, PubSubType().getName());
  return writer.WaitForReader(Clock::now() + std::chrono::seconds(4));
}

int Try(const BusOptions& options, const char* topic) {
  const bool is_read =
      std::strcmp(topic, "episode") == 0
          ? IsRead<wire::EpisodePubSubType>(options, dds::kEpisodeTopic)
          : IsRead<wire::RunDescriptionPubSubType>(options, dds::kRunDescriptionTopic);
  std::puts(is_read ? "is read" : "is not read");
  return 0;
}

}  // namespace
}  // namespace metronome::test

/// A writer that takes an identity's folder as it is, without this project's own checks: says
/// whether anyone reads it. dds_intruder RUN DOMAIN FOLDER episode|run_description
int main(int argc, char** argv) {
  if (argc != 5) return 2;
  metronome::BusOptions options;
  options.run_name = argv[1];
  options.domain = static_cast<std::uint32_t>(std::atoi(argv[2]));
  options.security = argv[3];
  return metronome::test::Try(options, argv[4]);
}
