#include "learner/sac/transition.h"

#include <algorithm>
#include <cstddef>

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

}  // namespace metronome::sac
