#include "actor/render/path_geoms.h"

#include <algorithm>
#include <cmath>

#include "actor/render/head_colors.h"

namespace metronome::render {
namespace {

constexpr mjtNum kTubeRadius = 0.005;       // metres
constexpr mjtNum kBallRadius = 0.011;       // metres
constexpr mjtNum kSmallBallRadius = 0.007;  // where there are many
constexpr int kManyHeads = 10;
constexpr mjtNum kShortest = 0.006;  // metres; shorter stretches of one head become one
constexpr float kEmission = 0.1F;    // so that a colour is itself in shadow too
// The lights of the scenes add up to more than white: with this, a lit tube has its head's colour.
constexpr float kBrightness = 0.8F / 255;

using Point = std::array<double, 3>;

double Distance(const Point& a, const Point& b) {
  return std::hypot(a[0] - b[0], a[1] - b[1], a[2] - b[2]);
}

mjvGeom Make(mjtGeom type, const std::array<mjtNum, 3>& size, const Point& place,
             const std::array<mjtNum, 9>& axes, const Color& color) {
  mjvGeom geom;
  const std::array<float, 4> rgba = {kBrightness * color[0], kBrightness * color[1],
                                     kBrightness * color[2], 1};
  mjv_initGeom(&geom, type, size.data(), place.data(), axes.data(), rgba.data());
  geom.category = mjCAT_DECOR;  // casts no shadow
  geom.emission = kEmission;
  geom.specular = 0;
  return geom;
}

mjvGeom Ball(const Point& place, const Color& color, std::int32_t heads) {
  const mjtNum radius = heads > kManyHeads ? kSmallBallRadius : kBallRadius;
  return Make(mjGEOM_SPHERE, {radius, 0, 0}, place, {1, 0, 0, 0, 1, 0, 0, 0, 1}, color);
}

// mjv_makeConnector of 2.2.2 and mjv_connector of 3.3.0 have other names and arguments.
mjvGeom Tube(const Point& from, const Point& to, const Color& color) {
  Point centre{};
  Point along{};
  for (std::size_t i = 0; i < 3; ++i) {
    centre[i] = (from[i] + to[i]) / 2;
    along[i] = to[i] - from[i];
  }
  std::array<mjtNum, 4> turn{};
  std::array<mjtNum, 9> axes{};
  mju_quatZ2Vec(turn.data(), along.data());
  mju_quat2Mat(axes.data(), turn.data());
  return Make(mjGEOM_CAPSULE, {kTubeRadius, Distance(from, to) / 2, 0}, centre, axes, color);
}

}  // namespace

std::vector<mjvGeom> PathGeoms(const EpisodePath& path, std::int32_t steps) {
  std::vector<mjvGeom> geoms;
  Point from = path.points.at(0).hand;
  for (std::int32_t t = 1; t <= steps; ++t) {
    const PathPoint& point = path.points.at(std::size_t(t));
    const Color color = HeadColor(point.head, path.heads);
    if (t == 1 || point.head != path.points[std::size_t(t) - 1].head) {
      geoms.push_back(Ball(path.points[std::size_t(t) - 1].hand, color, path.heads));
    }
    const bool last = t == steps || path.points[std::size_t(t) + 1].head != point.head;
    if (!last && Distance(from, point.hand) < kShortest) continue;
    if (Distance(from, point.hand) > 0) geoms.push_back(Tube(from, point.hand, color));
    from = point.hand;
  }
  return geoms;
}

}  // namespace metronome::render
