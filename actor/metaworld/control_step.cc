#include "actor/metaworld/control_step.h"

#include <algorithm>
#include <array>

namespace metronome::metaworld {
namespace {

constexpr int kMaxQpos = 64;  // Meta-World scenes have at most about 30

/// Whether mj_step would start from the very qpos and qvel of the last mj_forward. It would not
/// where it finds them bad and resets, nor where renormalising a quaternion changes its last bit:
/// MuJoCo 2.2.2's normalisation, done in place by mj_kinematics, is not idempotent.
bool KeepsState(const mjModel* m, const mjData* d) {
  const auto bad = [](mjtNum x) { return mju_isBad(x) != 0; };
  if (m->nq > kMaxQpos || std::any_of(d->qpos, d->qpos + m->nq, bad) ||
      std::any_of(d->qvel, d->qvel + m->nv, bad))
    return false;
  std::array<mjtNum, kMaxQpos> qpos;
  std::copy_n(d->qpos, m->nq, qpos.begin());
  mj_normalizeQuat(m, qpos.data());
  return std::equal(d->qpos, d->qpos + m->nq, qpos.begin());
}

/// mj_step where only mocap poses and controls are newer than the last mj_forward: contacts,
/// inertia and velocity terms are those that it left.
void StepAfterForward(const mjModel* m, mjData* d) {
  mj_kinematics(m, d);  // the mocap bodies' place
  mj_makeConstraint(m, d);
  mj_referenceConstraint(m, d);
  if (mjcb_control != nullptr) mjcb_control(m, d);
  mj_fwdActuation(m, d);
  mj_fwdAcceleration(m, d);
  mj_fwdConstraint(m, d);
  mj_checkAcc(m, d);
  mj_Euler(m, d);
}

}  // namespace

void ControlStep(const mjModel& model, mjData& data) {
  for (int i = 0; i < kPhysicsSteps; ++i) mj_step(&model, &data);
  mj_forward(&model, &data);
}

void ControlStepAfterForward(const mjModel& model, mjData& data) {
  if (!KeepsState(&model, &data)) return ControlStep(model, data);
  StepAfterForward(&model, &data);
  for (int i = 1; i < kPhysicsSteps; ++i) mj_step(&model, &data);
  mj_forward(&model, &data);
}

}  // namespace metronome::metaworld
