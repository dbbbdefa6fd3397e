#include "actor/metaworld/sawyer.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "actor/metaworld/assets.h"
#include "actor/metaworld/engine/control_step.h"

namespace metronome::metaworld {
namespace {

constexpr int kHandInitialisation = 50;                                   // control steps
constexpr int kShared = kHandInitialisation * engine::kPhysicsSteps - 1;  // substeps of it
constexpr float kActionScale = 0.01F;  // metres of mocap motion per unit of action
constexpr int kObjectQpos = 9;         // a free joint that follows 7 arm and 2 finger joints
constexpr int kObjectQvel = 9;
constexpr std::array<double, 4> kMocapQuaternion = {1, 0, 1, 0};  // un-normalised, as official

// Where step() clips hand and gripper of an observation to (metaworld 3.1.1, sawyer_xyz_env.py,
// sawyer_observation_space); the object is unbounded.
constexpr std::array<double, 4> kFrameLow = {-0.525, 0.348, -0.0525, -1};
constexpr std::array<double, 4> kFrameHigh = {0.525, 1.025, 0.7, 1};

void CopyChecked(const std::vector<double>& from, double* to, int size, const char* what) {
  if (static_cast<int>(from.size()) != size)
    throw std::invalid_argument(std::string("recorded ") + what + " has " +
                                std::to_string(from.size()) + " numbers, the scene needs " +
                                std::to_string(size));
  std::copy(from.begin(), from.end(), to);
}

bool Inside(const RandVec& p, const RandVec& low, const RandVec& high) {
  for (std::size_t i = 0; i < p.size(); ++i)
    if (!(low[i] <= p[i] && p[i] <= high[i])) return false;
  return true;
}

/// Quaternion (x, y, z, w) of a row-major rotation matrix in scipy's way: the largest of diagonal
/// and trace decides the formula, no sign rule.
Eigen::Vector4d QuaternionXyzw(const double* m) {
  const auto at = [m](int row, int column) { return m[3 * row + column]; };
  const double trace = at(0, 0) + at(1, 1) + at(2, 2);
  int choice = 0;
  for (int i = 1; i < 3; ++i)
    if (at(i, i) > at(choice, choice)) choice = i;
  Eigen::Vector4d q;
  if (trace > at(choice, choice)) {
    q << at(2, 1) - at(1, 2), at(0, 2) - at(2, 0), at(1, 0) - at(0, 1), 1 + trace;
  } else {
    const int i = choice, j = (i + 1) % 3, k = (i + 2) % 3;
    q[i] = 1 - trace + 2 * at(i, i);
    q[j] = at(j, i) + at(i, j);
    q[k] = at(k, i) + at(i, k);
    q[3] = at(k, j) - at(j, k);
  }
  return q / std::sqrt(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3]);
}

Box GoalBox(const TaskSpec& task) {
  return task.goal_box.value_or(Box{GoalOf(task.low), GoalOf(task.high)});
}

}  // namespace

SawyerEnvironment::SawyerEnvironment(const TaskSpec& task, const EnvironmentOptions& options)
    : scene_(engine::Scene::Load(options.assets.empty() ? DefaultAssetsPath() : options.assets,
                                 task.scene)),
      model_(scene_->model()),
      data_(scene_->MakeData()),
      task_(task),
      options_(options),
      goal_box_(GoalBox(task)),
      stepper_(*model_) {
  RequireOfficialScenes(options.assets.empty() ? DefaultAssetsPath() : options.assets);
  mocap_ = model_->body_mocapid[Body("mocap")];
  hand_ = Body("hand");
  right_claw_ = Body("rightclaw");
  left_claw_ = Body("leftclaw");
  right_pad_ = Body("rightpad");
  left_pad_ = Body("leftpad");
  right_tip_ = Site("rightEndEffector");
  left_tip_ = Site("leftEndEffector");
  right_pad_geom_ = Geom("rightpad_geom");
  left_pad_geom_ = Geom("leftpad_geom");
}

Observation SawyerEnvironment::Reset(const RandVec& placement) {
  if (!task_.hand.settles_alike || !Inside(placement, task_.low, task_.high))
    return ResetAfresh(placement);
  const mjData& settled = scene_->Settled(task_.name, [this](mjData& data) {
    EditModel(task_.low);  // any other placement would do
    InitialiseHand(data);
  });
  EditModel(placement);
  mj_copyData(data_.get(), model_.get(), &settled);
  return FinishReset(placement);
}

Observation SawyerEnvironment::ResetAfresh(const RandVec& placement) {
  EditModel(placement);
  InitialiseHand(*data_);
  return FinishReset(placement);
}

/// All of it but the last substep: what that leaves behind - positions one substep old, which some
/// resets show - has to have the fixed bodies where this episode's placement puts them.
void SawyerEnvironment::InitialiseHand(mjData& data) {
  mj_resetData(model_.get(), &data);
  stepper_.Begin(data);
  std::copy_n(task_.hand.initial.data(), 3, data.mocap_pos + 3 * mocap_);
  std::copy(kMocapQuaternion.begin(), kMocapQuaternion.end(), data.mocap_quat + 4 * mocap_);
  data.ctrl[0] = -1;
  data.ctrl[1] = 1;
  stepper_.Steps(data, kShared);
}

Observation SawyerEnvironment::FinishReset(const RandVec& placement) {
  stepper_.PlaceFixedBodies(*data_);
  stepper_.Steps(*data_, 1);
  tcp_init_ = Tcp();  // no mj_forward before: one physics step old, as in the official environment
  PlaceObject(placement);
  steps_ = 0;
  previous_frame_ = CurrentFrame();
  return Observe(previous_frame_);
}

StepResult SawyerEnvironment::Step(const Action& action) {
  if (steps_ >= kMaxSteps)
    throw std::logic_error("Environment::Step past step 500 or before Reset: call Reset first");
  for (const float component : action)
    if (!std::isfinite(component))
      throw std::invalid_argument("Environment::Step: an action component is not finite");
  MoveMocap(action);
  data_->ctrl[0] = action[3];
  data_->ctrl[1] = -action[3];
  // Some task may have left its reset without mj_forward, or with edits after it.
  if (steps_ == 0)
    stepper_.ControlStep(*data_);
  else
    stepper_.ControlStepAfterForward(*data_);
  ++steps_;
  return Conclude(action);
}

void SawyerEnvironment::MoveMocap(const Action& action) {
  double* position = data_->mocap_pos + 3 * mocap_;
  for (int i = 0; i < 3; ++i) {
    const float delta = std::clamp(action[i], -1.0F, 1.0F) * kActionScale;  // float32, as official
    position[i] =
        std::clamp(position[i] + static_cast<double>(delta), task_.hand.low[i], task_.hand.high[i]);
  }
  std::copy(kMocapQuaternion.begin(), kMocapQuaternion.end(), data_->mocap_quat + 4 * mocap_);
}

void SawyerEnvironment::Substeps() { stepper_.Steps(*data_, engine::kPhysicsSteps); }

StepResult SawyerEnvironment::Conclude(const Action& action) {
  StepResult result;
  const Frame previous = previous_frame_;
  previous_frame_ = CurrentFrame();
  result.observation = Observe(previous);
  Clip(result.observation);
  const Outcome outcome = Evaluate(result.observation, action);
  result.reward = outcome.reward;
  result.info = outcome.info;
  result.truncated = steps_ == kMaxSteps;
  return result;
}

SawyerEnvironment::Frame SawyerEnvironment::CurrentFrame() const {
  Frame frame{};
  const Eigen::Vector3d hand = BodyPosition(hand_);
  const double opening = Norm(BodyPosition(right_claw_) - BodyPosition(left_claw_));
  const ObjectPose object = Object(), second = SecondObject();
  std::copy_n(hand.data(), 3, frame.begin());
  frame[3] = std::clamp(opening / 0.1, 0.0, 1.0);  // claws are at most about 0.1 m apart
  std::copy_n(object.position.data(), 3, frame.begin() + 4);
  std::copy_n(object.quaternion.data(), 4, frame.begin() + 7);
  std::copy_n(second.position.data(), 3, frame.begin() + 11);
  std::copy_n(second.quaternion.data(), 4, frame.begin() + 14);
  return frame;
}

Observation SawyerEnvironment::Observe(const Frame& previous) const {
  Observation observation{};
  std::copy(previous_frame_.begin(), previous_frame_.end(), observation.begin());
  std::copy(previous.begin(), previous.end(), observation.begin() + kFrameSize);
  if (options_.goal_visible) std::copy_n(target_.data(), 3, observation.begin() + 2 * kFrameSize);
  return observation;
}

void SawyerEnvironment::Clip(Observation& observation) const {
  for (int frame : {0, kFrameSize})
    for (std::size_t i = 0; i < kFrameLow.size(); ++i) {
      double& number = observation[frame + i];
      number = std::clamp(number, kFrameLow[i], kFrameHigh[i]);
    }
  if (!options_.goal_visible) return;
  for (int i = 0; i < 3; ++i) {
    double& number = observation[2 * kFrameSize + i];
    number = std::clamp(number, goal_box_.low[i], goal_box_.high[i]);
  }
}

void SawyerEnvironment::MoveBody(int body, const Eigen::Vector3d& position) {
  std::copy_n(position.data(), 3, model_->body_pos + 3 * body);
}

void SawyerEnvironment::MoveSite(int site, const Eigen::Vector3d& position) {
  std::copy_n(position.data(), 3, model_->site_pos + 3 * site);
}

void SawyerEnvironment::SetQpos(int address, std::initializer_list<double> numbers) {
  std::copy(numbers.begin(), numbers.end(), data_->qpos + address);
}

void SawyerEnvironment::Stop(int address, int count) {
  std::fill_n(data_->qvel + address, count, 0.0);
}

void SawyerEnvironment::Forward() { mj_forward(model_.get(), data_.get()); }

void SawyerEnvironment::SetFreeObject(const Eigen::Vector3d& position) {
  SetQpos(kObjectQpos, {position.x(), position.y(), position.z()});
  Stop(kObjectQvel, 6);
  Forward();
}

CagingState SawyerEnvironment::CagingAt(const Eigen::Vector3d& object) const {
  return {BodyPosition(left_pad_).y(),
          BodyPosition(right_pad_).y(),
          Tcp(),
          object,
          tcp_init_,
          object_init_};
}

Scalar SawyerEnvironment::Caging(const Eigen::Vector3d& object, const CagingShape& shape,
                                 float gripper) const {
  return metaworld::Caging(CagingAt(object), shape, gripper);
}

bool SawyerEnvironment::Pinched(int geom) const {
  return NormalForce(left_pad_geom_, geom) > 0 && NormalForce(right_pad_geom_, geom) > 0;
}

/// Sum of the normal contact forces between `pad` and `geom`, newton.
double SawyerEnvironment::NormalForce(int pad, int geom) const {
  double force = 0;
  for (int i = 0; i < data_->ncon; ++i) {
    const mjContact& contact = data_->contact[i];
    const bool both = (contact.geom1 == pad && contact.geom2 == geom) ||
                      (contact.geom2 == pad && contact.geom1 == geom);
    if (both && contact.efc_address >= 0) force += data_->efc_force[contact.efc_address];
  }
  return force;
}

Eigen::Vector4d SawyerEnvironment::BodyQuaternion(int body) const {
  return Eigen::Map<const Eigen::Vector4d>(data_->xquat + 4 * body);
}

Eigen::Vector4d SawyerEnvironment::BodyMatrixQuaternion(int body) const {
  return QuaternionXyzw(data_->xmat + 9 * body);
}

Eigen::Vector4d SawyerEnvironment::SiteQuaternion(int site) const {
  return QuaternionXyzw(data_->site_xmat + 9 * site);
}

Eigen::Vector4d SawyerEnvironment::GeomQuaternion(int geom) const {
  return QuaternionXyzw(data_->geom_xmat + 9 * geom);
}

Eigen::Vector3d SawyerEnvironment::Tcp() const {
  return (SitePosition(right_tip_) + SitePosition(left_tip_)) / 2.0;
}

int SawyerEnvironment::Geom(const char* name) {
  const int geom = Find(mjOBJ_GEOM, name);
  stepper_.Watch(geom);
  return geom;
}

int SawyerEnvironment::Find(mjtObj type, const char* name) const {
  const int index = mj_name2id(model_.get(), type, name);
  if (index < 0)
    throw std::runtime_error("scene " + task_.scene + " has no \"" + name +
                             "\": not the official file of Meta-World 3.1.1");
  return index;
}

void SawyerEnvironment::Replay(const RecordedStart& start) {
  const auto take = [&start](const std::string& name, std::span<double> into) {
    const auto found = start.internals.find(name);
    if (found == start.internals.end())
      throw std::invalid_argument("recording lacks internals_after_reset." + name);
    CopyChecked(found->second, into.data(), static_cast<int>(into.size()), name.c_str());
  };
  take("init_tcp", {tcp_init_.data(), 3});
  take("obj_init_pos", {object_init_.data(), 3});
  for (const auto& [name, into] : remembered_) take(name, into);
  target_ = start.goal;
  std::copy_n(start.observation.begin(), kFrameSize, previous_frame_.begin());
  const auto recorded = [this](mjtObj type, const char* kind, const std::string& name) {
    const int index = mj_name2id(model_.get(), type, name.c_str());
    if (index < 0)
      throw std::invalid_argument(std::string("recorded ") + kind + " \"" + name +
                                  "\" is not in the scene " + task_.scene);
    return index;
  };
  for (const auto& [name, position] : start.bodies)
    std::copy_n(position.data(), 3, model_->body_pos + 3 * recorded(mjOBJ_BODY, "body", name));
  for (const auto& [name, position] : start.sites)
    std::copy_n(position.data(), 3, model_->site_pos + 3 * recorded(mjOBJ_SITE, "site", name));
  steps_ = 0;
}

StepResult SawyerEnvironment::ReplayStep(const RecordedState& state, const Action& action,
                                         int step) {
  CopyChecked(state.qpos, data_->qpos, model_->nq, "qpos");
  CopyChecked(state.qvel, data_->qvel, model_->nv, "qvel");
  CopyChecked(state.mocap_pos, data_->mocap_pos, 3 * model_->nmocap, "mocap_pos");
  CopyChecked(state.mocap_quat, data_->mocap_quat, 4 * model_->nmocap, "mocap_quat");
  CopyChecked(state.ctrl, data_->ctrl, model_->nu, "ctrl");
  CopyChecked(state.qacc_warmstart, data_->qacc_warmstart, model_->nv, "warm");
  mj_forward(model_.get(), data_.get());
  steps_ = step;
  return Conclude(action);
}

}  // namespace metronome::metaworld
