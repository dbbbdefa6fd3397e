#include "actor/play/canonical_episode.h"

#include <openssl/evp.h>

#include <array>
#include <cmath>
#include <memory>
#include <stdexcept>
#include <vector>

#include "actor/metaworld/placement.h"
#include "actor/metaworld/sawyer.h"
#include "actor/metaworld/tasks/task_table.h"
#include "common/config/config.h"
#include "common/numbers/random.h"
#include "common/policy/head_schedule.h"
#include "common/policy/network.h"
#include "common/policy/policy.h"

namespace metronome {
namespace {

constexpr int kSteps = 100;
constexpr int kElementaryInputs = 400;
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

void AddElementary(Digest& digest) {
  RandomStream stream(RandomPurpose::kEvaluate, kSeed, kNumber, 1);
  for (int i = 0; i < kElementaryInputs; ++i) {
    const double x = 10 * (2 * stream.Uniform() - 1);
    for (const double y : {std::exp(x), std::log(std::abs(x)), std::sin(x), std::cos(x),
                           std::tanh(x), std::sqrt(std::abs(x)), stream.Normal()})
      digest.Add(y);
    const auto single = static_cast<float>(x);
    for (const float y : {std::exp(single), std::log(std::abs(single)), std::tanh(single)})
      digest.Add(y);
  }
}

void AddEpisode(Digest& digest, const std::string& task, const std::string& assets) {
  const auto environment =
      metaworld::MakeEnvironment(task, {.goal_visible = true, .assets = assets});
  RandomStream stream(RandomPurpose::kEvaluate, kSeed, kNumber, kPlacementDraw);
  const auto add = [&digest](const metaworld::Observation& observation) {
    for (const double number : observation) digest.Add(static_cast<float>(number));
  };
  add(environment->Reset(metaworld::DrawPlacement(metaworld::FindTask(task), stream)));
  for (int t = 0; t < kSteps; ++t) {
    metaworld::Action action{};
    for (float& component : action) component = static_cast<float>(2 * stream.Uniform() - 1);
    const metaworld::StepResult result = environment->Step(action);
    add(result.observation);
    digest.Add(static_cast<float>(result.reward));
  }
}

std::string EnvironmentDigest(const std::string& task, const std::string& assets) {
  Digest digest;
  AddElementary(digest);
  AddEpisode(digest, task, assets);
  return digest.Hex();
}

/// Not the run's own: what matters is written out, so that no new default changes the digest.
RunConfig PolicyConfiguration() {
  RunConfig config;
  config.mutable_environment()->set_task("push");
  config.mutable_environment()->set_horizon(kSteps);
  auto& policy = *config.mutable_policy();
  policy.set_method(MULTIHEAD);
  policy.set_heads(10);
  policy.add_hidden(128);
  policy.add_hidden(128);
  policy.set_observation_clip(10);
  policy.set_schedule(SCHEDULE_BLOCKS);
  return Resolve(config);
}

std::string PolicyDigest() {
  const RunConfig config = PolicyConfiguration();
  RandomStream stream(RandomPurpose::kEvaluate, kSeed, kNumber, 2);
  const auto uniform = [&stream](std::size_t count, double bound) {
    std::vector<float> numbers(count);
    for (float& number : numbers) number = float(bound * (2 * stream.Uniform() - 1));
    return numbers;
  };
  PolicySnapshot snapshot;
  snapshot.parameters = uniform(ActorLayout(ShapeOf(config)).size, 0.25);
  snapshot.observation_mean = uniform(kObservationSize, 1);
  snapshot.observation_inv_std = uniform(kObservationSize, 4);
  Policy policy(config, snapshot);
  const HeadSchedule schedule(config, TrainingEpisode(config, 0));
  Digest digest;
  for (std::int32_t t = 0; t < kSteps; ++t) {
    const std::vector<float> observation = uniform(kObservationSize, 2);
    std::array<float, kActionSize> noise{};
    for (float& number : noise) number = float(stream.Normal());
    const Policy::Decision decision = policy.Act(schedule, observation.data(), t, noise);
    for (const float number : decision.mean) digest.Add(number);
    for (const float number : decision.action) digest.Add(number);
    digest.Add(decision.log_prob);
  }
  return digest.Hex();
}

}  // namespace

std::string CanonicalDigest(const std::string& task, const std::string& assets) {
  return EnvironmentDigest(task, assets) + PolicyDigest();
}

}  // namespace metronome
