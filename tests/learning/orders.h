#pragma once

#include <cstdint>
#include <vector>

#include "actor/environment/registry.h"

namespace metronome::test {

/// What orders are worth.
struct OrderRules {
  std::vector<double> worth;  // [T] of what arrives at a step, each of it
  std::int32_t delay = 1;     // steps from an order to its arrival
  bool terminates = false;    // whether step T is the end, or the time limit
};

/// Each step orders from -1 to 1 (action 0), which costs half its square at once, and takes from
/// nothing to all (action 1, from -1 to 1) of what was ordered `delay` steps before. An observation
/// has what is to arrive, the next one first: nothing in it tells the time, which alone says what
/// things are worth.
environment::EnvironmentEntry Orders(const OrderRules& rules);

/// The return of who orders what will be worth it, discounted, and nothing that would arrive after
/// step T; and takes what is worth something.
double BestReturn(const OrderRules& rules, double discount);

}  // namespace metronome::test
