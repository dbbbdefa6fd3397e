#pragma once

#include <mujoco/mujoco.h>

#include <array>
#include <vector>

namespace metronome::metaworld::engine {

/// Rounded boxes around geoms, and how far apart two geoms surely are. Immutable, hence
/// thread-safe.
class GeomBounds {
 public:
  explicit GeomBounds(const mjModel& model);

  /// Whether the geoms are farther from each other than `margin` (metres) and 0.05 mm, which is far
  /// above what the engine's iterative collision functions (tolerance 1e-6) could take for a touch.
  /// False may mean anything.
  [[nodiscard]] bool SurelyApart(const mjData& data, int geom1, int geom2, mjtNum margin) const {
    return Clearance(data, geom1, geom2, margin) > 0;
  }

  /// How far the geoms may move towards each other until SurelyApart may say no, at least, metres.
  /// Zero or less may mean anything.
  [[nodiscard]] mjtNum Clearance(const mjData& data, int geom1, int geom2, mjtNum margin) const;

 private:
  using Vector = std::array<mjtNum, 3>;

  /// A box, grown by a disk around its z axis and by a ball: capsules and cylinders are no boxes.
  struct Bounds {
    bool plane = false;
    Vector centre{};  // of the box, in the geom's frame, metres
    Vector half{};    // half sizes of the box, metres
    mjtNum disk = 0;  // radius, metres
    mjtNum ball = 0;  // radius, metres

    [[nodiscard]] mjtNum Reach(const Vector& direction) const;
  };
  struct Pair;

  static Bounds Of(const mjModel& model, int geom);
  static Bounds OfMesh(const mjModel& model, int geom);
  [[nodiscard]] mjtNum AbovePlane(const mjData& data, int plane, int geom) const;
  [[nodiscard]] mjtNum Between(const mjData& data, int geom1, int geom2) const;

  std::vector<Bounds> bounds_;  // [ngeom]
};

}  // namespace metronome::metaworld::engine
