#include "actor/metaworld/engine/geom_bounds.h"

#include <algorithm>
#include <cmath>

namespace metronome::metaworld::engine {
namespace {

constexpr mjtNum kSlack = 5e-5;   // metres
constexpr mjtNum kPlenty = 1e-2;  // metres: a gap that is not worth to be known better

using Vector = std::array<mjtNum, 3>;

// m^T v, m row-major 3 x 3: v in the frame whose axes are the columns of m.
Vector Rotated(const mjtNum* m, const Vector& v) {
  return {m[0] * v[0] + m[3] * v[1] + m[6] * v[2], m[1] * v[0] + m[4] * v[1] + m[7] * v[2],
          m[2] * v[0] + m[5] * v[1] + m[8] * v[2]};
}

// Centre of a box in the world: position + m * local.
Vector Placed(const mjtNum* position, const mjtNum* m, const Vector& local) {
  Vector world;
  for (int i = 0; i < 3; ++i) {
    world[i] =
        position[i] + m[3 * i] * local[0] + m[3 * i + 1] * local[1] + m[3 * i + 2] * local[2];
  }
  return world;
}

}  // namespace

GeomBounds::GeomBounds(const mjModel& model) {
  bounds_.reserve(static_cast<std::size_t>(model.ngeom));
  for (int geom = 0; geom < model.ngeom; ++geom) bounds_.push_back(Of(model, geom));
}

GeomBounds::Bounds GeomBounds::Of(const mjModel& model, int geom) {
  const mjtNum* size = model.geom_size + 3 * geom;
  Bounds bounds;
  switch (model.geom_type[geom]) {
    case mjGEOM_PLANE:
      bounds.plane = true;
      break;
    case mjGEOM_CAPSULE:
      bounds.half[2] = size[1];
      bounds.ball = size[0];
      break;
    case mjGEOM_CYLINDER:
      bounds.half[2] = size[1];
      bounds.disk = size[0];
      break;
    case mjGEOM_ELLIPSOID:
    case mjGEOM_BOX:
      bounds.half = {size[0], size[1], size[2]};
      break;
    case mjGEOM_MESH:
      return OfMesh(model, geom);
    default:
      bounds.ball = model.geom_rbound[geom];
  }
  return bounds;
}

GeomBounds::Bounds GeomBounds::OfMesh(const mjModel& model, int geom) {
  const int mesh = model.geom_dataid[geom];
  const float* vertex = model.mesh_vert + 3 * model.mesh_vertadr[mesh];
  Vector low{vertex[0], vertex[1], vertex[2]};
  Vector high = low;
  for (int i = 0; i < 3 * model.mesh_vertnum[mesh]; ++i) {
    low[i % 3] = std::min(low[i % 3], mjtNum{vertex[i]});
    high[i % 3] = std::max(high[i % 3], mjtNum{vertex[i]});
  }
  Bounds bounds;
  for (int i = 0; i < 3; ++i) {
    bounds.centre[i] = (low[i] + high[i]) / 2;
    bounds.half[i] = (high[i] - low[i]) / 2;
  }
  return bounds;
}

/// @param direction  of length 1, in the geom's frame.
mjtNum GeomBounds::Bounds::Reach(const Vector& direction) const {
  const auto [x, y, z] = direction;
  return half[0] * std::abs(x) + half[1] * std::abs(y) + half[2] * std::abs(z) +
         disk * std::sqrt(x * x + y * y) + ball;
}

/// Bounds of two geoms, and how they lie to each other.
struct GeomBounds::Pair {
  const Bounds& a;
  const Bounds& b;
  std::array<Vector, 3> rows;     // row i is axis i of `a` in the frame of `b`
  std::array<Vector, 3> columns;  // the transpose: axes of `b` in the frame of `a`
  Vector to_b, to_a;              // from one centre to the other, in the frames of `a`, of `b`

  [[nodiscard]] mjtNum FaceGap() const;
  [[nodiscard]] mjtNum EdgeGap() const;
  static mjtNum RoundGap(const Bounds& round, const Vector& offset,
                         const std::array<Vector, 3>& axes, const Bounds& other);
};

/// The widest gap along an axis of either frame.
mjtNum GeomBounds::Pair::FaceGap() const {
  constexpr std::array<Vector, 3> kAxes = {Vector{1, 0, 0}, Vector{0, 1, 0}, Vector{0, 0, 1}};
  mjtNum widest = -mjMAXVAL;
  for (std::size_t i = 0; i < 3; ++i) {
    widest = std::max(widest, std::abs(to_b[i]) - a.Reach(kAxes[i]) - b.Reach(rows[i]));
    widest = std::max(widest, std::abs(to_a[i]) - b.Reach(kAxes[i]) - a.Reach(columns[i]));
  }
  return widest;
}

/// The widest gap along the products of two edges. They have length sqrt(1 - r^2), at most 1: the
/// boxes are as far apart, at least.
mjtNum GeomBounds::Pair::EdgeGap() const {
  mjtNum widest = -mjMAXVAL;
  for (std::size_t i = 0; i < 3; ++i) {
    const std::size_t i1 = (i + 1) % 3, i2 = (i + 2) % 3;
    for (std::size_t j = 0; j < 3; ++j) {
      const std::size_t j1 = (j + 1) % 3, j2 = (j + 2) % 3;
      const mjtNum reach = a.half[i1] * std::abs(rows[i2][j]) + a.half[i2] * std::abs(rows[i1][j]) +
                           b.half[j1] * std::abs(rows[i][j2]) + b.half[j2] * std::abs(rows[i][j1]);
      widest = std::max(widest, std::abs(to_b[i2] * rows[i1][j] - to_b[i1] * rows[i2][j]) - reach);
    }
  }
  return widest - (a.disk + a.ball + b.disk + b.ball);
}

/// The gap along the shortest way from the round geom's axis, or point, to the other's centre.
/// @param offset  of the other's centre. @param axes  of the other; both in the round one's frame.
mjtNum GeomBounds::Pair::RoundGap(const Bounds& round, const Vector& offset,
                                  const std::array<Vector, 3>& axes, const Bounds& other) {
  if (round.disk + round.ball == 0) return -mjMAXVAL;
  Vector way = offset;
  if (round.half[2] > 0) way[2] = 0;
  const mjtNum length = std::sqrt(way[0] * way[0] + way[1] * way[1] + way[2] * way[2]);
  if (!(length > mjMINVAL)) return -mjMAXVAL;
  for (mjtNum& x : way) x /= length;
  Vector in_other;
  for (std::size_t j = 0; j < 3; ++j) {
    in_other[j] = way[0] * axes[j][0] + way[1] * axes[j][1] + way[2] * axes[j][2];
  }
  return length - round.Reach(way) - other.Reach(in_other);
}

mjtNum GeomBounds::Clearance(const mjData& data, int geom1, int geom2, mjtNum margin) const {
  const mjtNum gap = std::max(margin, mjtNum{0}) + kSlack;
  if (bounds_[static_cast<std::size_t>(geom1)].plane) return AbovePlane(data, geom1, geom2) - gap;
  if (bounds_[static_cast<std::size_t>(geom2)].plane) return AbovePlane(data, geom2, geom1) - gap;
  return Between(data, geom1, geom2) - gap;
}

mjtNum GeomBounds::AbovePlane(const mjData& data, int plane, int geom) const {
  const Bounds& bounds = bounds_[static_cast<std::size_t>(geom)];
  const mjtNum* m = data.geom_xmat + 9 * plane;
  const Vector normal{m[2], m[5], m[8]};
  const mjtNum* on = data.geom_xpos + 3 * plane;
  const mjtNum* axes = data.geom_xmat + 9 * geom;
  const Vector centre = Placed(data.geom_xpos + 3 * geom, axes, bounds.centre);
  mjtNum height = 0;
  for (std::size_t i = 0; i < 3; ++i) height += normal[i] * (centre[i] - on[i]);
  return height - bounds.Reach(Rotated(axes, normal));
}

mjtNum GeomBounds::Between(const mjData& data, int geom1, int geom2) const {
  const Bounds& a = bounds_[static_cast<std::size_t>(geom1)];
  const Bounds& b = bounds_[static_cast<std::size_t>(geom2)];
  const mjtNum* axes1 = data.geom_xmat + 9 * geom1;
  const mjtNum* axes2 = data.geom_xmat + 9 * geom2;
  const Vector from = Placed(data.geom_xpos + 3 * geom1, axes1, a.centre);
  const Vector to = Placed(data.geom_xpos + 3 * geom2, axes2, b.centre);
  const Vector offset{to[0] - from[0], to[1] - from[1], to[2] - from[2]};
  Pair pair{a, b, {}, {}, Rotated(axes1, offset), Rotated(axes2, offset)};
  for (std::size_t i = 0; i < 3; ++i) {
    pair.rows[i] = Rotated(axes2, {axes1[i], axes1[3 + i], axes1[6 + i]});
    for (std::size_t j = 0; j < 3; ++j) pair.columns[j][i] = pair.rows[i][j];
  }
  const mjtNum faces = pair.FaceGap();
  if (faces > kPlenty) return faces;
  const Vector back{-pair.to_a[0], -pair.to_a[1], -pair.to_a[2]};
  return std::max({faces, pair.EdgeGap(), Pair::RoundGap(a, pair.to_b, pair.columns, b),
                   Pair::RoundGap(b, back, pair.rows, a)});
}

}  // namespace metronome::metaworld::engine
