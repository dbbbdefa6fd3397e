/// Episodes that decode, against the run: lengths, heads, flags, numbers. The check must have an
/// answer for each.
#include <cstdint>
#include <cstring>

#include "common/config/config.h"
#include "common/policy/network.h"
#include "common/policy/policy.h"
#include "learner/algorithm/episode_check.h"
#include "tests/unit/support/environments.h"

namespace metronome {
namespace {

constexpr int kHorizon = 4;

RunConfig SmallRun() {
  RunConfig config;
  test::SetTask(config, "push");
  config.mutable_environment()->set_horizon(kHorizon);
  config.mutable_policy()->set_heads(2);
  config.mutable_policy()->add_hidden(8);
  return config::Resolve(config);
}

PolicySnapshot SomeSnapshot(const RunConfig& config) {
  PolicySnapshot snapshot;
  snapshot.parameters.assign(policy::ActorLayout(policy::ShapeOf(config)).size, 0.01F);
  snapshot.observation_mean.assign(test::kObservationSize, 0);
  snapshot.observation_inv_std.assign(test::kObservationSize, 1);
  return snapshot;
}

/// Takes values from the front of the input, zeros once it is used up.
class Input {
 public:
  Input(const std::uint8_t* data, std::size_t size) : data_(data), size_(size) {}
  template <class T>
  T Take() {
    T value{};
    const std::size_t bytes = std::min(sizeof value, size_);
    std::memcpy(&value, data_, bytes);
    data_ += bytes;
    size_ -= bytes;
    return value;
  }
  template <class T>
  std::vector<T> TakeSome(std::size_t usual) {
    // Now and then another length than the run's.
    std::vector<T> values(usual + (Take<std::uint8_t>() == 255 ? 1 : 0));
    for (T& value : values) value = Take<T>();
    return values;
  }

 private:
  const std::uint8_t* data_;
  std::size_t size_;
};

Episode EpisodeOf(Input input) {
  Episode episode;
  episode.number = input.Take<std::uint64_t>();
  episode.weights_version = input.Take<std::uint8_t>();
  episode.head = input.TakeSome<std::uint16_t>(kHorizon);
  episode.flags = input.TakeSome<std::uint8_t>(kHorizon);
  episode.reward = input.TakeSome<float>(kHorizon);
  episode.log_prob = input.TakeSome<float>(kHorizon);
  episode.action = input.TakeSome<float>(kHorizon * test::kActionSize);
  episode.observation = input.TakeSome<float>((kHorizon + 1) * test::kObservationSize);
  return episode;
}

}  // namespace
}  // namespace metronome

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static const metronome::RunConfig config = metronome::SmallRun();
  static metronome::policy::Policy policy(config, metronome::SomeSnapshot(config));
  const auto episode = metronome::EpisodeOf(metronome::Input(data, size));
  (void)metronome::algorithm::CheckEpisode(episode, policy, config, 1);
  return 0;
}
