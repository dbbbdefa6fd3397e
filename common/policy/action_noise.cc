#include "common/policy/action_noise.h"

#include <cmath>

#include "common/numbers/random.h"

namespace metronome::policy {

ActionNoise::ActionNoise(const RunConfig& config, std::uint64_t number)
    : size_(config.environment().spec().action_size()),
      seed_(config.seed()),
      number_(number),
      correlation_(config.policy().noise_correlation()) {}

ActionNoise::Doubles ActionNoise::Independent(std::int32_t t) const {
  numbers::RandomStream stream(numbers::RandomPurpose::kTrain, seed_, number_,
                               static_cast<std::uint64_t>(t));
  Doubles numbers{};
  for (std::int32_t i = 0; i < size_; ++i) numbers[i] = stream.Normal();
  return numbers;
}

ActionNoise::Numbers ActionNoise::At(std::int32_t t) {
  if (correlation_ == 0) {
    state_ = Independent(t);
  } else {
    if (t < t_ || t_ < 0) {
      state_ = Independent(0);
      t_ = 0;
    }
    const double fresh = std::sqrt(1 - correlation_ * correlation_);
    while (t_ < t) {
      const auto independent = Independent(++t_);
      for (std::int32_t i = 0; i < size_; ++i) {
        state_[i] = correlation_ * state_[i] + fresh * independent[i];
      }
    }
  }
  Numbers numbers{};
  for (std::int32_t i = 0; i < size_; ++i) numbers[i] = static_cast<float>(state_[i]);
  return numbers;
}

}  // namespace metronome::policy
