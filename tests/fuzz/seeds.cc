/// Writes what the fuzzers begin with: DIR/TARGET/NAME, one valid input of each target and kind.
#include <cstdio>
#include <exception>
#include <filesystem>
#include <fstream>
#include <string>

#include "common/checkpoint/checkpoint.h"
#include "common/config/config.h"
#include "learner/ppo/ppo_algorithm.h"
#include "tests/integration/dds_fixture.h"
#include "tests/integration/raw_writer.h"
#include "tests/unit/support/environments.h"

namespace metronome::fuzz {
namespace {

namespace fs = std::filesystem;

class Corpus {
 public:
  explicit Corpus(fs::path folder) : folder_(std::move(folder)) {}

  void Write(const std::string& target, const std::string& name, const std::string& bytes) const {
    fs::create_directories(folder_ / target);
    std::ofstream(folder_ / target / name, std::ios::binary) << bytes;
  }

  template <class PubSubType, class Message>
  void WriteSample(const std::string& target, const std::string& name,
                   const Message& message) const {
    const test::Bytes bytes = test::Encode<PubSubType>(message);
    Write(target, name, std::string(bytes.begin(), bytes.end()));
  }

 private:
  const fs::path folder_;
};

RunConfig SmallRun() {
  RunConfig config;
  test::SetTask(config, "push");
  config.mutable_policy()->set_heads(2);
  config.mutable_policy()->add_hidden(4);
  return config::Resolve(config);
}

void WriteWire(const Corpus& corpus) {
  RunDescription description = test::SomeDescription(1, "run");
  description.config = SmallRun().SerializeAsString();
  corpus.WriteSample<wire::RunDescriptionPubSubType>("RunDescription", "one", description);
  corpus.WriteSample<wire::PolicySnapshotPubSubType>("PolicySnapshot", "one",
                                                     test::SomeSnapshot(3, 40));
  corpus.WriteSample<wire::EpisodeAssignmentPubSubType>("EpisodeAssignment", "run",
                                                        test::SomeAssignment(11, 5));
  EpisodeAssignment refusal = test::SomeAssignment(11, 5);
  refusal.kind = EpisodeAssignment::Kind::kRefuse;
  refusal.numbers.clear();
  refusal.reason = "another engine";
  corpus.WriteSample<wire::EpisodeAssignmentPubSubType>("EpisodeAssignment", "refuse", refusal);
  corpus.WriteSample<wire::EpisodePubSubType>("Episode", "two-steps", test::SomeEpisode(7, 2));
  corpus.WriteSample<wire::ActorStatusPubSubType>("ActorStatus", "one", test::SomeStatus(11));
  corpus.WriteSample<wire::LearnerStatusPubSubType>("LearnerStatus", "two-actors",
                                                    test::SomeLearnerStatus(3));
}

void WriteFiles(const Corpus& corpus) {
  const RunConfig config = SmallRun();
  checkpoint::Checkpoint checkpoint;
  checkpoint.config = config;
  checkpoint.engine = "mujoco-0.0.0";
  checkpoint.state = ppo::MakePpoFactory()->InitialState(config, nullptr);
  const std::string whole = checkpoint::EncodeCheckpoint(checkpoint);
  constexpr std::size_t kPayloadAt = 52;  // common/README.md
  corpus.Write("checkpoint", "whole", '\0' + whole);
  corpus.Write("checkpoint", "payload", '\1' + whole.substr(kPayloadAt));
  corpus.Write("config", "text", '\0' + config::PrintConfig(config));
  corpus.Write("config", "setting", "\1policy.hidden=64,64");
  corpus.Write("config", "bytes", '\2' + config.SerializeAsString());
}

}  // namespace
}  // namespace metronome::fuzz

int main(int argc, char** argv) {
  if (argc != 2) {
    std::fprintf(stderr, "usage: fuzz_seeds DIR\n");
    return 2;
  }
  try {
    const metronome::fuzz::Corpus corpus(argv[1]);
    metronome::fuzz::WriteWire(corpus);
    metronome::fuzz::WriteFiles(corpus);
    return 0;
  } catch (const std::exception& error) {
    std::fprintf(stderr, "fuzz_seeds: %s\n", error.what());
    return 1;
  }
}
