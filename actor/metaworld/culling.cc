#include "actor/metaworld/culling.h"

#include <mujoco/mujoco.h>

#include <algorithm>
#include <array>
#include <cmath>

#if mjVERSION_HEADER < 300

namespace metronome::metaworld {
namespace {

/// Pairs closer than this are left to the engine, metres: far above what its iterative collision
/// functions (tolerance 1e-6) could take for a touch.
constexpr mjtNum kSlack = 1e-3;

using Functions = std::array<std::array<mjfCollision, mjNGEOMTYPES>, mjNGEOMTYPES>;

// The engine's own functions, [smaller type][larger type]; null where it has none.
const Functions& EngineFunctions() {
  static const Functions functions = [] {
    Functions copy{};
    for (int i = 0; i < mjNGEOMTYPES; ++i)
      std::copy_n(mjCOLLISIONFUNC[i], mjNGEOMTYPES, copy[i].begin());
    return copy;
  }();
  return functions;
}

/// Whether the bounding sphere of `geom` is farther than `gap` from the box `box`.
bool ClearOfBox(const mjModel* m, const mjData* d, int box, int geom, mjtNum gap) {
  if (m->geom_type[box] != mjGEOM_BOX || m->geom_rbound[geom] <= 0) return false;  // 0: unbounded
  const mjtNum* axes = d->geom_xmat + 9 * box;                                     // columns
  const mjtNum* half = m->geom_size + 3 * box;
  const mjtNum* from = d->geom_xpos + 3 * box;
  const mjtNum* to = d->geom_xpos + 3 * geom;
  const mjtNum offset[3] = {to[0] - from[0], to[1] - from[1], to[2] - from[2]};
  mjtNum squared = 0;  // distance from the sphere's centre to the box
  for (int i = 0; i < 3; ++i) {
    const mjtNum along = axes[i] * offset[0] + axes[3 + i] * offset[1] + axes[6 + i] * offset[2];
    const mjtNum outside = std::max(std::abs(along) - half[i], mjtNum{0});
    squared += outside * outside;
  }
  const mjtNum reach = m->geom_rbound[geom] + gap;
  return squared > reach * reach;
}

int CollideUnlessClear(const mjModel* m, const mjData* d, mjContact* contacts, int g1, int g2,
                       mjtNum margin) {
  const mjtNum gap = std::max(margin, mjtNum{0}) + kSlack;
  if (ClearOfBox(m, d, g1, g2, gap) || ClearOfBox(m, d, g2, g1, gap)) return 0;
  return EngineFunctions()[m->geom_type[g1]][m->geom_type[g2]](m, d, contacts, g1, g2, margin);
}

}  // namespace

void SetCulling(bool on) {
  const Functions& own = EngineFunctions();
  for (int i = 0; i < mjNGEOMTYPES; ++i)
    for (int j = 0; j < mjNGEOMTYPES; ++j) {
      const bool with_box = i == mjGEOM_BOX || j == mjGEOM_BOX;
      const bool cull = on && with_box && own[i][j] != nullptr;
      mjCOLLISIONFUNC[i][j] = cull ? CollideUnlessClear : own[i][j];
    }
}

}  // namespace metronome::metaworld

#else

namespace metronome::metaworld {

void SetCulling(bool) {}

}  // namespace metronome::metaworld

#endif
