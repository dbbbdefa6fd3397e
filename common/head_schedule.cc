#include "common/head_schedule.h"

#include <stdexcept>
#include <string>

namespace metronome {

HeadSchedule::HeadSchedule(std::int32_t heads, std::int32_t horizon)
    : heads_(heads), horizon_(horizon) {
  if (heads < 1 || heads > horizon) {
    throw std::invalid_argument("heads = " + std::to_string(heads) +
                                " must be at least 1 and at most the horizon of " +
                                std::to_string(horizon) + " steps");
  }
}

std::int32_t HeadSchedule::HeadAt(std::int32_t t) const {
  if (t < 0 || t >= horizon_) {
    throw std::out_of_range("step " + std::to_string(t) + " is outside an episode of " +
                            std::to_string(horizon_) + " steps");
  }
  // Integers, 64-bit product: t * (k / T) in double gives 0 at t = 49, k = 2, T = 98.
  return static_cast<std::int32_t>(std::int64_t{t} * heads_ / horizon_);
}

std::int32_t HeadSchedule::ValueHeadAt(std::int32_t t) const {
  return t == horizon_ ? heads_ - 1 : HeadAt(t);
}

}  // namespace metronome
