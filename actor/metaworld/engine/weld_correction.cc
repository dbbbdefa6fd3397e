#include "actor/metaworld/engine/weld_correction.h"

#include <mujoco/mujoco.h>

#if mjVERSION_HEADER < 300

#include <algorithm>

namespace metronome::metaworld::engine {
namespace {

/// Rewrites the three rotational rows of the weld that starts at `row`. Runs between
/// mj_referenceConstraint and the solver, which read and write:
///   pos   residual, made rotational-error * torquescale here
///   KBIP  stiffness K, damping B, impedance I of the row
///   aref = -B * vel - K * I * pos,   D = 1 / R = inverse regularisation.
void CorrectWeld(const mjModel& m, mjData& d, int weld, int row) {
  const mjtNum torquescale = m.eq_data[weld * mjNEQDATA + 10];
  const int hand = m.eq_obj2id[weld];
  const mjtNum weight = m.body_invweight0[2 * hand] / m.body_invweight0[2 * hand + 1];
  for (int i = row + 3; i < row + 6; ++i) {
    const mjtNum* kbip = d.efc_KBIP + 4 * i;
    d.efc_pos[i] *= torquescale;
    d.efc_aref[i] = -kbip[1] * d.efc_vel[i] - kbip[0] * kbip[2] * d.efc_pos[i];
    d.efc_D[i] *= weight;
    d.efc_R[i] = 1 / d.efc_D[i];
  }
}

void CorrectWelds(const mjModel* m, mjData* d) {
  for (int row = 0; row < d->ne;) {
    const int equality = d->efc_id[row];
    const bool weld = m->eq_type[equality] == mjEQ_WELD;
    if (weld) CorrectWeld(*m, *d, equality, row);
    row += weld ? 6 : m->eq_type[equality] == mjEQ_CONNECT ? 3 : 1;
  }
}

}  // namespace

void InstallWeldCorrection() { mjcb_control = CorrectWelds; }

}  // namespace metronome::metaworld::engine

#else

namespace metronome::metaworld::engine {

void InstallWeldCorrection() {}

}  // namespace metronome::metaworld::engine

#endif
