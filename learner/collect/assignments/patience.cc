#include "learner/collect/assignments/patience.h"

#include <algorithm>

namespace metronome::collect::assignments {
namespace {

constexpr std::uint32_t kMostDoublings = 6;

}  // namespace

std::chrono::nanoseconds Patience::Lost(std::uint32_t tries) const {
  const std::uint32_t doublings = std::min(std::max(tries, 1U) - 1, kMostDoublings);
  return Scaled(rules_.lost_factor * double(1U << doublings));
}

std::chrono::nanoseconds Patience::Scaled(double factor) const {
  const std::chrono::nanoseconds median =
      durations_.median().value_or(std::chrono::nanoseconds(rules_.first_estimate));
  // The floor keeps the proportion between late and lost.
  const double scale = factor / rules_.late_factor;
  const std::chrono::duration<double, std::nano> wanted = factor * median;
  const std::chrono::duration<double, std::nano> least =
      scale * std::chrono::nanoseconds(rules_.least_late);
  return std::chrono::duration_cast<std::chrono::nanoseconds>(std::max(wanted, least));
}

}  // namespace metronome::collect::assignments
