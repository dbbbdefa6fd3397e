#include "learner/run/background_update.h"

#include <chrono>
#include <utility>

namespace metronome::run {

BackgroundUpdate::BackgroundUpdate(algorithm::Algorithm* algorithm, Background* background,
                                   std::function<TimePoint()> now, std::function<void()> wake)
    : algorithm_(*algorithm),
      background_(*background),
      now_(std::move(now)),
      wake_(std::move(wake)) {}

BackgroundUpdate::~BackgroundUpdate() { background_.Wait(); }

void BackgroundUpdate::Start(collect::Collector::Collected collected, double collect_seconds) {
  Outcome begun;
  begun.collected = std::move(collected);
  begun.collect_seconds = collect_seconds;
  background_.Start([this, outcome = std::move(begun)]() mutable { Learn(std::move(outcome)); });
  runs_ = true;
}

// In the other thread.
void BackgroundUpdate::Learn(Outcome outcome) {
  const TimePoint begin = now_();
  try {
    outcome.report = algorithm_.Update(*outcome.collected.batch);
  } catch (...) {
    outcome.error = std::current_exception();
  }
  outcome.seconds = std::chrono::duration<double>(now_() - begin).count();
  {
    const process::MutexLock lock(mutex_);
    outcome_ = std::move(outcome);
  }
  wake_();
}

std::optional<BackgroundUpdate::Outcome> BackgroundUpdate::Take() {
  std::optional<Outcome> outcome;
  {
    const process::MutexLock lock(mutex_);
    outcome.swap(outcome_);
  }
  if (!outcome) return std::nullopt;
  background_.Wait();  // it has nothing left to do but to return
  runs_ = false;
  return outcome;
}

}  // namespace metronome::run
