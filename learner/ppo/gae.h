#pragma once

#include <vector>

namespace metronome::ppo {

struct GaeParameters {
  double discount = 0.99;  // gamma, per environment step
  double lambda = 0.95;
};

struct GaeResult {
  std::vector<float> advantage;  // [T]
  std::vector<float> target;     // [T], advantage + value: what the critic regresses on
};

/// Generalized advantage estimation over one whole episode of T steps.
/// @param reward       [T], after scaling.
/// @param value        [T], V(s_t).
/// @param final_value  V(s_T): 0 where nothing follows, be it that s_T is absorbing or the horizon.
/// @throws std::invalid_argument if the lengths differ.
/// Source: Schulman et al., arXiv:1506.02438, eq. 16, in its backward form.
GaeResult ComputeGae(const std::vector<float>& reward, const std::vector<float>& value,
                     float final_value, const GaeParameters& parameters);

}  // namespace metronome::ppo
