#pragma once

#include <mujoco/mujoco.h>

#include <array>
#include <vector>

namespace metronome::metaworld::engine {

/// Boxes and spheres around geoms, and the test whether two geoms are surely apart. Immutable,
/// hence thread-safe.
class GeomBounds {
 public:
  explicit GeomBounds(const mjModel& model);

  /// Whether the geoms are farther from each other than `margin` (metres) and a millimetre, which
  /// is far above what the engine's iterative collision functions (tolerance 1e-6) could take for a
  /// touch. False may mean anything.
  [[nodiscard]] bool SurelyApart(const mjData& data, int geom1, int geom2, mjtNum margin) const;

 private:
  struct Bounds {
    bool plane = false;
    mjtNum radius = 0;               // of the sphere around the geom's own origin, metres
    std::array<mjtNum, 3> centre{};  // of the box, in the geom's frame, metres
    std::array<mjtNum, 3> half{};    // half sizes of the box, metres
  };

  static Bounds Of(const mjModel& model, int geom);
  static Bounds OfMesh(const mjModel& model, int geom);
  [[nodiscard]] bool PlaneApart(const mjData& data, int plane, int geom, mjtNum gap) const;
  [[nodiscard]] bool BoxesApart(const mjData& data, int geom1, int geom2, mjtNum gap) const;

  std::vector<Bounds> bounds_;  // [ngeom]
};

}  // namespace metronome::metaworld::engine
