#include "learner/sac/transition.h"

#include <algorithm>
#include <cstddef>
#include <tuple>

#include "common/numbers/random.h"
#include "common/policy/network.h"

namespace metronome::sac {

Transition TransitionAt(const ReplayStep& step, const SacConfig& sac) {
  const ReplayEpisode& of = *step.of;
  const std::int32_t length = of.episode.length();
  Transition transition;
  transition.step = step;
  transition.head = of.episode.head[std::size_t(step.t)];
  transition.next_t = std::min(step.t + sac.n_step(), length);
  double discount = 1;
  double reward = 0;
  for (std::int32_t t = step.t; t < transition.next_t; ++t) {
    reward += discount * of.episode.reward[std::size_t(t)];
    discount *= sac.discount();
  }
  transition.reward = float(reward);
  const bool last = transition.next_t == length;
  transition.next_head = last ? of.final_head : of.episode.head[std::size_t(transition.next_t)];
  transition.next_discount = last && !of.bootstraps ? 0 : float(discount);
  return transition;
}

namespace {

// Whether a head's sample number i is to be of an episode with success.
bool OfSuccess(const Replay& replay, std::int32_t head, std::uint64_t i, double share) {
  const auto steps = double(replay.SuccessStepsOf(head));
  if (steps == 0 || steps >= share * double(replay.StepsOf(head))) return false;
  return std::uint64_t(double(i + 1) * share) > std::uint64_t(double(i) * share);
}

}  // namespace

std::vector<Transition> DrawBatch(const Replay& replay, const RunConfig& config,
                                  std::uint64_t gradient_step) {
  std::vector<std::int32_t> heads;
  for (std::int32_t head = 0; head < policy::ShapeOf(config).heads; ++head) {
    if (replay.StepsOf(head) > 0) heads.push_back(head);
  }
  numbers::RandomStream random(numbers::RandomPurpose::kReplay, config.seed(), gradient_step, 0);
  // Where the samples are no multiple of the heads, those that get one more change.
  const std::uint64_t first = random.Below(heads.size());
  std::vector<Transition> batch;
  for (std::int32_t i = 0; i < config.sac().batch(); ++i) {
    const std::int32_t head = heads[(first + std::uint64_t(i)) % heads.size()];
    const bool success =
        OfSuccess(replay, head, std::uint64_t(i) / heads.size(), config.sac().success_share());
    const ReplayStep step =
        success ? replay.SuccessStepOf(head, random.Below(replay.SuccessStepsOf(head)))
                : replay.StepOf(head, random.Below(replay.StepsOf(head)));
    batch.push_back(TransitionAt(step, config.sac()));
  }
  std::stable_sort(batch.begin(), batch.end(), [](const Transition& a, const Transition& b) {
    return std::tie(a.head, a.next_head) < std::tie(b.head, b.next_head);
  });
  return batch;
}

}  // namespace metronome::sac
