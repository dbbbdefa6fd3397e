#pragma once

#include <mujoco/mujoco.h>

#include <array>
#include <cstdint>
#include <vector>

namespace metronome::metaworld::engine {

/// How far geoms have moved, and how often: two geoms that were apart need no other look before
/// they have travelled as much, or at all. Not thread-safe.
class GeomTravel {
 public:
  /// @param model  must outlive this; its geoms may not change.
  explicit GeomTravel(const mjModel& model);

  /// Of geoms that are not followed, nothing is known.
  void Follow(int geom);

  /// Adds what each geom has moved since the last call, whatever mjData that was given.
  /// @return false if travels begin anew at 0: at the first call, after a pose that is not finite,
  ///         and where they would become too large to be exact.
  [[nodiscard]] bool Add(const mjData& data);

  /// Metres that any point of the geom has moved at most.
  [[nodiscard]] mjtNum Of(int geom) const { return travel_[static_cast<std::size_t>(geom)]; }
  /// How many calls of Add found the geom elsewhere than the one before. Never begins anew.
  [[nodiscard]] std::int64_t Moves(int geom) const {
    return moves_[static_cast<std::size_t>(geom)];
  }

 private:
  struct Pose {
    int geom = 0;
    mjtNum radius = 0;  // of the sphere around the geom's own origin, metres
    std::array<mjtNum, 3> position{};
    std::array<mjtNum, 9> axes{};
  };

  const mjModel& model_;
  std::vector<Pose> poses_;          // of the geoms that are followed
  std::vector<mjtNum> travel_;       // [ngeom]
  std::vector<std::int64_t> moves_;  // [ngeom]
};

}  // namespace metronome::metaworld::engine
