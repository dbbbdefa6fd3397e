#include "learner/sac/draw_batch.h"

#include <algorithm>
#include <cstddef>
#include <tuple>

#include "common/numbers/elementary.h"
#include "common/numbers/random.h"
#include "common/policy/network.h"

namespace metronome::sac {
namespace {

// Whether number i of many is one of a share of them, evenly spread.
bool IsOfShare(std::uint64_t i, double share) {
  return std::uint64_t(double(i + 1) * share) > std::uint64_t(double(i) * share);
}

// From 0, below count.
std::size_t DrawRank(std::size_t count, numbers::RandomStream& random) {
  const double r = numbers::Exp(random.Uniform() * numbers::Log(double(count + 1)));
  return std::min(std::size_t(r), count) - 1;
}

// The samples of one head.
class HeadDraws {
 public:
  HeadDraws(const Replay& replay, const SacConfig& sac, std::int32_t head)
      : replay_(replay), head_(head), best_share_(sac.best_share()) {
    const auto steps = double(replay.SuccessStepsOf(head));
    const bool rare = steps > 0 && steps < sac.success_share() * double(replay.StepsOf(head));
    success_share_ = rare ? sac.success_share() : 0;
  }

  ReplayStep Next(numbers::RandomStream& random) {
    if (IsOfShare(drawn_++, success_share_)) {
      return replay_.SuccessStepOf(head_, random.Below(replay_.SuccessStepsOf(head_)));
    }
    const ReplayStep any = replay_.StepOf(head_, random.Below(replay_.StepsOf(head_)));
    return IsOfShare(others_++, best_share_) ? OfBest(any, random) : any;
  }

 private:
  // A step of the head in an episode of the same task as the step's. Where that has none, it ended
  // before, the step itself.
  ReplayStep OfBest(const ReplayStep& step, numbers::RandomStream& random) const {
    const std::size_t task = step.of->task;
    const ReplayEpisode& best = replay_.BestOf(task, DrawRank(replay_.EpisodesOf(task), random));
    const auto& heads = best.episode.head;
    const auto steps = std::count(heads.begin(), heads.end(), head_);
    if (steps == 0) return step;
    auto left = random.Below(std::uint64_t(steps)) + 1;
    const auto found = std::find_if(heads.begin(), heads.end(),
                                    [&](auto head) { return head == head_ && --left == 0; });
    return {&best, std::int32_t(found - heads.begin())};
  }

  const Replay& replay_;
  std::int32_t head_;
  double success_share_ = 0;
  double best_share_;
  std::uint64_t drawn_ = 0;
  std::uint64_t others_ = 0;  // of them without those of success
};

}  // namespace

std::vector<Transition> DrawBatch(const Replay& replay, const RunConfig& config,
                                  std::uint64_t gradient_step) {
  std::vector<HeadDraws> heads;
  for (std::int32_t head = 0; head < policy::ShapeOf(config).heads; ++head) {
    if (replay.StepsOf(head) > 0) heads.emplace_back(replay, config.sac(), head);
  }
  numbers::RandomStream random(numbers::RandomPurpose::kReplay, config.seed(), gradient_step, 0);
  // Where the samples are no multiple of the heads, those that get one more change.
  const std::uint64_t first = random.Below(heads.size());
  std::vector<Transition> batch;
  for (std::int32_t i = 0; i < config.sac().batch(); ++i) {
    HeadDraws& head = heads[(first + std::uint64_t(i)) % heads.size()];
    batch.push_back(TransitionAt(head.Next(random), config.sac()));
  }
  std::stable_sort(batch.begin(), batch.end(), [](const Transition& a, const Transition& b) {
    return std::tie(a.head, a.next_head) < std::tie(b.head, b.next_head);
  });
  return batch;
}

}  // namespace metronome::sac
