#include "actor/play/canonical_episode.h"

#include <openssl/evp.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <stdexcept>
#include <vector>

#include "common/config/config.h"
#include "common/numbers/random.h"
#include "common/policy/head_schedule.h"
#include "common/policy/network.h"
#include "common/policy/policy.h"

namespace metronome::play {
namespace {

constexpr int kSteps = 100;
constexpr int kElementaryInputs = 20000;  // variants differ in less than one result of a thousand
constexpr std::uint64_t kSeed = 0;
// Far from any episode that is trained on or evaluated.
constexpr std::uint64_t kNumber = ~std::uint64_t{0};

class Digest {
 public:
  Digest() : context_(EVP_MD_CTX_new(), EVP_MD_CTX_free) {
    Check(context_ && EVP_DigestInit_ex(context_.get(), EVP_sha256(), nullptr) == 1);
  }

  template <class Number>
  void Add(Number number) {
    Check(EVP_DigestUpdate(context_.get(), &number, sizeof(number)) == 1);
  }

  std::string Hex() {
    std::array<unsigned char, EVP_MAX_MD_SIZE> bytes{};
    unsigned int size = 0;
    Check(EVP_DigestFinal_ex(context_.get(), bytes.data(), &size) == 1);
    std::string hex;
    for (unsigned int i = 0; i < size; ++i) {
      hex += "0123456789abcdef"[bytes[i] >> 4];
      hex += "0123456789abcdef"[bytes[i] & 15];
    }
    return hex;
  }

 private:
  static void Check(bool ok) {
    if (!ok) throw std::runtime_error("SHA-256 of the canonical episode: OpenSSL failed");
  }

  std::unique_ptr<EVP_MD_CTX, decltype(&EVP_MD_CTX_free)> context_;
};

/// Of the C library, which has variants by processor: all that MuJoCo calls. (The variants of
/// float32 give equal bits.)
void AddElementary(Digest& digest) {
  numbers::RandomStream stream(numbers::RandomPurpose::kEvaluate, kSeed, kNumber, 1);
  for (int i = 0; i < kElementaryInputs; ++i) {
    const double unit = 2 * stream.Uniform() - 1;
    const double x = 10 * (2 * stream.Uniform() - 1);
    for (const double y :
         {std::exp(x), std::log(std::abs(x)), std::pow(std::abs(x), unit), std::sin(x), std::cos(x),
          std::tan(x), std::asin(unit), std::acos(unit), std::atan2(x, unit), stream.Normal()})
      digest.Add(y);
  }
}

/// @param environment  of the specification.
void AddEpisode(Digest& digest, const EnvironmentSpec& spec,
                environment::Environment& environment) {
  std::vector<float> observation(std::size_t(spec.observation_size()));
  std::vector<float> action(std::size_t(spec.action_size()));
  const auto add_observation = [&] {
    for (const float number : observation) digest.Add(number);
  };
  environment::EpisodeStart start({numbers::RandomPurpose::kEvaluate, kSeed, kNumber});
  const auto reset = [&] {
    environment.Reset(start, observation);
    add_observation();
  };
  reset();
  for (int t = 0; t < kSteps; ++t) {
    for (int i = 0; i < spec.action_size(); ++i) {
      const double low = spec.action_low(i);
      action[std::size_t(i)] =
          static_cast<float>(low + (spec.action_high(i) - low) * start.random.Uniform());
    }
    const environment::StepOutcome step = environment.Step(action, observation);
    add_observation();
    digest.Add(static_cast<float>(step.reward));
    if (step.terminated || step.truncated) reset();
  }
}

std::string EnvironmentDigest(const environment::EnvironmentRegistry& registry,
                              const EnvironmentConfig& config) {
  Digest digest;
  AddElementary(digest);
  const int tasks = std::max(1, config.spec().tasks_size());
  for (int task = 0; task < tasks; ++task)
    AddEpisode(digest, config.spec(), *registry.Make(config, static_cast<std::size_t>(task)));
  return digest.Hex();
}

/// Not the run's own: what matters is written out, so that no new default changes the digest.
RunConfig PolicyConfiguration(const EnvironmentConfig& environment) {
  RunConfig config;
  *config.mutable_environment() = environment;
  config.mutable_environment()->set_horizon(kSteps);
  auto& policy = *config.mutable_policy();
  policy.set_method(MULTIHEAD);
  policy.set_heads(10);
  policy.add_hidden(128);
  policy.add_hidden(128);
  policy.set_observation_clip(10);
  policy.set_schedule(SCHEDULE_BLOCKS);
  return config::Resolve(config);
}

std::string PolicyDigest(const EnvironmentConfig& environment) {
  const RunConfig config = PolicyConfiguration(environment);
  const policy::NetworkShape shape = policy::ShapeOf(config);
  const auto observations = std::size_t(shape.observation);
  numbers::RandomStream stream(numbers::RandomPurpose::kEvaluate, kSeed, kNumber, 2);
  const auto uniform = [&stream](std::size_t count, double bound) {
    std::vector<float> numbers(count);
    for (float& number : numbers) number = float(bound * (2 * stream.Uniform() - 1));
    return numbers;
  };
  PolicySnapshot snapshot;
  snapshot.parameters = uniform(policy::ActorLayout(shape).size, 0.25);
  snapshot.observation_mean = uniform(shape.statistics(), 1);
  snapshot.observation_inv_std = uniform(shape.statistics(), 4);
  policy::Policy policy(config, snapshot);
  const auto schedule = policy::HeadSchedule::OfTraining(config, 0);
  Digest digest;
  for (std::int32_t t = 0; t < kSteps; ++t) {
    const std::vector<float> observation = uniform(observations, 2);
    policy::Policy::Action noise{};
    for (std::int32_t i = 0; i < shape.action; ++i) noise[i] = float(stream.Normal());
    const policy::Policy::Decision decision = policy.Act(schedule, observation.data(), t, noise);
    for (const auto& numbers : {decision.mean, decision.action}) {
      for (std::int32_t i = 0; i < shape.action; ++i) digest.Add(numbers[i]);
    }
    digest.Add(decision.log_prob);
  }
  return digest.Hex();
}

}  // namespace

std::string CanonicalDigest(const environment::EnvironmentRegistry& registry,
                            const std::string& task) {
  EnvironmentConfig config;  // its defaults: random placements, the goal visible
  *config.mutable_spec() = registry.Describe(task);
  config.set_task(config.spec().short_name());
  return EnvironmentDigest(registry, config) + PolicyDigest(config);
}

}  // namespace metronome::play
