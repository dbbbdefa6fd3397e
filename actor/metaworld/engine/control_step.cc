#include "actor/metaworld/engine/control_step.h"

#include <algorithm>
#include <array>
#include <stdexcept>

namespace metronome::metaworld::engine {
namespace {

constexpr int kMaxQpos = 64;  // Meta-World scenes have at most about 30

/// Whether mj_step would find the state bad: it warns then, and starts from the default one.
bool IsBad(const mjModel* m, const mjData* d) {
  const auto bad = [](mjtNum x) { return mju_isBad(x) != 0; };
  return std::any_of(d->qpos, d->qpos + m->nq, bad) || std::any_of(d->qvel, d->qvel + m->nv, bad);
}

/// Whether mj_step would start from the very qpos and qvel of the last mj_forward. It would not
/// where it finds them bad, nor where renormalising a quaternion changes its last bit:
/// MuJoCo 2.2.2's normalisation, done in place by mj_kinematics, is not idempotent.
bool KeepsState(const mjModel* m, const mjData* d) {
  if (m->nq > kMaxQpos || IsBad(m, d)) return false;
  std::array<mjtNum, kMaxQpos> qpos;
  std::copy_n(d->qpos, m->nq, qpos.begin());
  mj_normalizeQuat(m, qpos.data());
  return std::equal(d->qpos, d->qpos + m->nq, qpos.begin());
}

bool UsesIslands([[maybe_unused]] const mjModel& m) {
#if mjVERSION_HEADER < 300
  return false;
#else
  return (m.opt.enableflags & mjENBL_ISLAND) != 0;
#endif
}

bool Moves(const mjModel& m, int body) {
  return m.body_weldid[body] != 0 || m.body_mocapid[m.body_rootid[body]] >= 0;
}

/// mj_kinematics, for mocap bodies alone (they hang on the world). It normalises their quaternions
/// twice, which is not the same bits as once.
void PlaceMocapBodies(const mjModel& m, mjData& d) {
  for (int i = 0; i < m.nbody; ++i) {
    const int mocap = m.body_mocapid[i];
    if (mocap < 0) continue;
    mju_copy3(d.xpos + 3 * i, d.mocap_pos + 3 * mocap);
    mju_copy4(d.xquat + 4 * i, d.mocap_quat + 4 * mocap);
    mju_normalize4(d.xquat + 4 * i);
    mju_normalize4(d.xquat + 4 * i);
    mju_quat2Mat(d.xmat + 9 * i, d.xquat + 4 * i);
    mj_local2Global(&d, d.xipos + 3 * i, d.ximat + 9 * i, m.body_ipos + 3 * i, m.body_iquat + 4 * i,
                    i, m.body_sameframe[i]);
  }
}

}  // namespace

ControlStepper::ControlStepper(const mjModel& model)
    : model_(model), bodies_only_(model), pairs_(model) {
  if (model.nsensor > 0 || model.opt.integrator != mjINT_EULER || UsesIslands(model)) {
    throw std::logic_error(
        "the scene has sensors, solver islands, or another integrator than Euler's");
  }
  bodies_only_.ngeom = bodies_only_.nsite = 0;
  for (int geom = 0; geom < model.ngeom; ++geom) {
    const bool collides = model.geom_contype[geom] != 0 || model.geom_conaffinity[geom] != 0;
    if (collides && Moves(model, model.geom_bodyid[geom])) geoms_.push_back(geom);
  }
  for (int site = 0; site < model.nsite; ++site) {
    if (Moves(model, model.site_bodyid[site])) sites_.push_back(site);
  }
}

void ControlStepper::Watch(int geom) {
  if (std::find(geoms_.begin(), geoms_.end(), geom) == geoms_.end()) geoms_.push_back(geom);
}

void ControlStepper::Begin(mjData& data) const { mj_kinematics(&model_, &data); }

void ControlStepper::PlaceFixedBodies(mjData& data) const {
  const std::vector<mjtNum> qpos(data.qpos, data.qpos + model_.nq);
  Begin(data);
  std::copy(qpos.begin(), qpos.end(), data.qpos);
}

void ControlStepper::Kinematics(mjData& d) const {
  const mjModel& m = model_;
  mj_kinematics(&bodies_only_, &d);
  for (const int i : geoms_) {
    mj_local2Global(&d, d.geom_xpos + 3 * i, d.geom_xmat + 9 * i, m.geom_pos + 3 * i,
                    m.geom_quat + 4 * i, m.geom_bodyid[i], m.geom_sameframe[i]);
  }
  for (const int i : sites_) {
    mj_local2Global(&d, d.site_xpos + 3 * i, d.site_xmat + 9 * i, m.site_pos + 3 * i,
                    m.site_quat + 4 * i, m.site_bodyid[i], m.site_sameframe[i]);
  }
}

// mj_forward, stage by stage.
void ControlStepper::Forward(mjData& d) {
  const mjModel* m = &model_;
  Kinematics(d);
  mj_comPos(m, &d);
  mj_tendon(m, &d);
  mj_crb(m, &d);
  mj_factorM(m, &d);
  pairs_.Collide(d);
  mj_makeConstraint(m, &d);
  mj_transmission(m, &d);
  mj_projectConstraint(m, &d);
  mj_fwdVelocity(m, &d);
  if (mjcb_control != nullptr) mjcb_control(m, &d);
  mj_fwdActuation(m, &d);
  mj_fwdAcceleration(m, &d);
  mj_fwdConstraint(m, &d);
}

void ControlStepper::Step(mjData& d) {
  if (IsBad(&model_, &d)) return mj_step(&model_, &d);
  Forward(d);
  mj_checkAcc(&model_, &d);
  mj_Euler(&model_, &d);
}

/// mj_step where only mocap poses and controls are newer than the last mj_forward: contacts,
/// inertia and velocity terms are those that it left.
void ControlStepper::StepAfterForward(mjData& d) const {
  const mjModel* m = &model_;
  PlaceMocapBodies(*m, d);
  mj_makeConstraint(m, &d);
  mj_referenceConstraint(m, &d);
  if (mjcb_control != nullptr) mjcb_control(m, &d);
  mj_fwdActuation(m, &d);
  mj_fwdAcceleration(m, &d);
  mj_fwdConstraint(m, &d);
  mj_checkAcc(m, &d);
  mj_Euler(m, &d);
}

void ControlStepper::Steps(mjData& data, int count) {
  for (int i = 0; i < count; ++i) Step(data);
}

void ControlStepper::ControlStep(mjData& data) {
  Steps(data, kPhysicsSteps);
  Forward(data);
}

void ControlStepper::ControlStepAfterForward(mjData& data) {
  if (!KeepsState(&model_, &data)) return ControlStep(data);
  StepAfterForward(data);
  Steps(data, kPhysicsSteps - 1);
  Forward(data);
}

}  // namespace metronome::metaworld::engine
