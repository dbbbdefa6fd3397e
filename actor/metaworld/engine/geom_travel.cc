#include "actor/metaworld/engine/geom_travel.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>

namespace metronome::metaworld::engine {
namespace {

constexpr mjtNum kFarthest = 1e2;     // metres; sums of steps up to here lose less than 1e-14 each
constexpr mjtNum kPlaneRadius = 1e3;  // metres; no scene is as large

template <std::size_t kSize>
bool SameBits(const mjtNum* a, const std::array<mjtNum, kSize>& b) {
  return std::memcmp(a, b.data(), sizeof b) == 0;
}

/// Distance of two arrays; the second becomes the first.
template <std::size_t kSize>
mjtNum Replace(const mjtNum* now, std::array<mjtNum, kSize>& before) {
  mjtNum squared = 0;
  for (std::size_t i = 0; i < kSize; ++i) {
    const mjtNum moved = now[i] - before[i];
    squared += moved * moved;
    before[i] = now[i];
  }
  return std::sqrt(squared);
}

}  // namespace

GeomTravel::GeomTravel(const mjModel& model)
    : model_(model),
      travel_(static_cast<std::size_t>(model.ngeom)),
      moves_(static_cast<std::size_t>(model.ngeom)) {}

void GeomTravel::Follow(int geom) {
  for (const Pose& pose : poses_) {
    if (pose.geom == geom) return;
  }
  Pose pose;
  pose.geom = geom;
  pose.position.fill(std::numeric_limits<mjtNum>::quiet_NaN());  // not known yet
  pose.radius = model_.geom_type[geom] == mjGEOM_PLANE ? kPlaneRadius : model_.geom_rbound[geom];
  poses_.push_back(pose);
}

/// A rotation moves no point by more than the matrices' distance (Frobenius's norm) times its own
/// distance from the origin.
bool GeomTravel::Add(const mjData& data) {
  bool exact = true;
  for (Pose& pose : poses_) {
    const mjtNum* position = data.geom_xpos + 3 * pose.geom;
    const mjtNum* axes = data.geom_xmat + 9 * pose.geom;
    if (SameBits(position, pose.position) && SameBits(axes, pose.axes)) continue;
    mjtNum& travel = travel_[static_cast<std::size_t>(pose.geom)];
    travel += Replace(position, pose.position) + pose.radius * Replace(axes, pose.axes);
    exact = exact && travel < kFarthest;
    ++moves_[static_cast<std::size_t>(pose.geom)];
  }
  if (!exact) std::fill(travel_.begin(), travel_.end(), 0);
  return exact;
}

}  // namespace metronome::metaworld::engine
