#include "actor/metaworld/engine/geom_bounds.h"

#include <algorithm>
#include <cmath>

namespace metronome::metaworld::engine {
namespace {

constexpr mjtNum kSlack = 1e-3;  // metres

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
  bounds.radius = model.geom_rbound[geom];
  switch (model.geom_type[geom]) {
    case mjGEOM_PLANE:
      bounds.plane = true;
      break;
    case mjGEOM_SPHERE:
      bounds.half = {size[0], size[0], size[0]};
      break;
    case mjGEOM_CAPSULE:
      bounds.half = {size[0], size[0], size[0] + size[1]};
      break;
    case mjGEOM_CYLINDER:
      bounds.half = {size[0], size[0], size[1]};
      break;
    case mjGEOM_ELLIPSOID:
    case mjGEOM_BOX:
      bounds.half = {size[0], size[1], size[2]};
      break;
    case mjGEOM_MESH:
      return OfMesh(model, geom);
    default:
      bounds.half = {bounds.radius, bounds.radius, bounds.radius};
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
  bounds.radius = model.geom_rbound[geom];
  for (int i = 0; i < 3; ++i) {
    bounds.centre[i] = (low[i] + high[i]) / 2;
    bounds.half[i] = (high[i] - low[i]) / 2;
  }
  return bounds;
}

bool GeomBounds::SurelyApart(const mjData& data, int geom1, int geom2, mjtNum margin) const {
  const mjtNum gap = std::max(margin, mjtNum{0}) + kSlack;
  const Bounds& a = bounds_[static_cast<std::size_t>(geom1)];
  const Bounds& b = bounds_[static_cast<std::size_t>(geom2)];
  if (a.plane) return PlaneApart(data, geom1, geom2, gap);
  if (b.plane) return PlaneApart(data, geom2, geom1, gap);
  const mjtNum* from = data.geom_xpos + 3 * geom1;
  const mjtNum* to = data.geom_xpos + 3 * geom2;
  const Vector offset{to[0] - from[0], to[1] - from[1], to[2] - from[2]};
  const mjtNum reach = a.radius + b.radius + gap;
  const mjtNum squared = offset[0] * offset[0] + offset[1] * offset[1] + offset[2] * offset[2];
  return squared > reach * reach || BoxesApart(data, geom1, geom2, gap);
}

// Signed distance of the box's nearest corner above the plane.
bool GeomBounds::PlaneApart(const mjData& data, int plane, int geom, mjtNum gap) const {
  const Bounds& box = bounds_[static_cast<std::size_t>(geom)];
  const mjtNum* m = data.geom_xmat + 9 * plane;
  const Vector normal{m[2], m[5], m[8]};
  const mjtNum* on = data.geom_xpos + 3 * plane;
  const mjtNum* axes = data.geom_xmat + 9 * geom;
  const Vector centre = Placed(data.geom_xpos + 3 * geom, axes, box.centre);
  const Vector along = Rotated(axes, normal);
  mjtNum height = 0;
  for (int i = 0; i < 3; ++i) {
    height += normal[i] * (centre[i] - on[i]) - std::abs(along[i]) * box.half[i];
  }
  return height > gap;
}

// Separating axes: the faces' normals of both boxes, then the products of their edges.
bool GeomBounds::BoxesApart(const mjData& data, int geom1, int geom2, mjtNum gap) const {
  const Bounds& a = bounds_[static_cast<std::size_t>(geom1)];
  const Bounds& b = bounds_[static_cast<std::size_t>(geom2)];
  const mjtNum* axes1 = data.geom_xmat + 9 * geom1;
  const mjtNum* axes2 = data.geom_xmat + 9 * geom2;
  const Vector from = Placed(data.geom_xpos + 3 * geom1, axes1, a.centre);
  const Vector to = Placed(data.geom_xpos + 3 * geom2, axes2, b.centre);
  const Vector offset{to[0] - from[0], to[1] - from[1], to[2] - from[2]};
  const Vector t = Rotated(axes1, offset);  // in the frame of box 1
  mjtNum r[3][3];                           // axes of box 2 in the frame of box 1, as columns
  mjtNum r_abs[3][3];
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) {
      r[i][j] = axes1[i] * axes2[j] + axes1[3 + i] * axes2[3 + j] + axes1[6 + i] * axes2[6 + j];
      r_abs[i][j] = std::abs(r[i][j]);
    }
    const mjtNum reach =
        a.half[i] + r_abs[i][0] * b.half[0] + r_abs[i][1] * b.half[1] + r_abs[i][2] * b.half[2];
    if (std::abs(t[i]) > reach + gap) return true;
  }
  for (int j = 0; j < 3; ++j) {
    const mjtNum reach =
        b.half[j] + r_abs[0][j] * a.half[0] + r_abs[1][j] * a.half[1] + r_abs[2][j] * a.half[2];
    const mjtNum distance = t[0] * r[0][j] + t[1] * r[1][j] + t[2] * r[2][j];
    if (std::abs(distance) > reach + gap) return true;
  }
  for (int i = 0; i < 3; ++i) {
    const int i1 = (i + 1) % 3, i2 = (i + 2) % 3;
    for (int j = 0; j < 3; ++j) {
      const int j1 = (j + 1) % 3, j2 = (j + 2) % 3;
      // The product of the two edges, of length sqrt(1 - r^2): at most 1, so `gap` is asked for
      // at least.
      const mjtNum reach = a.half[i1] * r_abs[i2][j] + a.half[i2] * r_abs[i1][j] +
                           b.half[j1] * r_abs[i][j2] + b.half[j2] * r_abs[i][j1];
      if (std::abs(t[i2] * r[i1][j] - t[i1] * r[i2][j]) > reach + gap) return true;
    }
  }
  return false;
}

}  // namespace metronome::metaworld::engine
