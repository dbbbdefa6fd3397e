#pragma once

#include "actor/metaworld/reward_terms.h"
#include "common/numbers/elementary.h"

/// Rewards for a hand that stays high until it is over what it wants, clear of walls.
namespace metronome::metaworld {

/// A surface around a vertical axis: 0 within `radius`, beyond it slope ln(r - radius) + height.
struct Funnel {
  double radius, slope, height;  // metres
};

inline double FunnelHeight(const Funnel& funnel, double r) {
  return r > funnel.radius ? funnel.slope * numbers::Log(r - funnel.radius) + funnel.height : 0;
}

/// 1 at the height of `floor` and above, less below.
inline double AboveFloor(double height, double floor, double margin) {
  return height >= floor ? 1 : LongTail(floor - height, 0, 0.01, margin);
}

}  // namespace metronome::metaworld
