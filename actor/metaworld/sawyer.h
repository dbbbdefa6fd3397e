#pragma once

#include <Eigen/Core>
#include <initializer_list>
#include <map>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "actor/metaworld/engine/control_step.h"
#include "actor/metaworld/engine/engine.h"
#include "actor/metaworld/reward_terms.h"
#include "actor/metaworld/step_result.h"
#include "actor/metaworld/task_spec.h"

namespace metronome::metaworld {

inline constexpr int kFrameSize = 18;  // hand 3, gripper 1, object 3 + 4, a second object's 3 + 4

/// The two halves of a placement, metres.
inline Eigen::Vector3d ObjectOf(const RandVec& placement) {
  return Eigen::Map<const Eigen::Vector3d>(placement.data());
}
inline Eigen::Vector3d GoalOf(const RandVec& placement) {
  return Eigen::Map<const Eigen::Vector3d>(placement.data() + 3);
}

/// Where and how the manipulated object is, as the observation shows it.
struct ObjectPose {
  Eigen::Vector3d position = Eigen::Vector3d::Zero();
  /// (w, x, y, z) of a body, (x, y, z, w) of a rotation matrix, or zeros, by task.
  Eigen::Vector4d quaternion = Eigen::Vector4d::Zero();
};

struct Outcome {
  double reward = 0;
  StepInfo info;
};

/// The beginning of a recorded episode, as far as a replay needs it.
struct RecordedStart {
  Observation observation{};
  Eigen::Vector3d goal;
  std::map<std::string, std::vector<double>> internals;  // by official attribute; scalars are [1]
  std::map<std::string, Eigen::Vector3d> bodies, sites;  // positions in their parents
};

/// The physical state after a recorded step.
struct RecordedState {
  std::vector<double> qpos, qvel, mocap_pos, mocap_quat, ctrl, qacc_warmstart;
};

/// The Sawyer arm that all Meta-World scenes share: mocap action, observation, clip, time limit and
/// the order of a reset (metaworld 3.1.1, sawyer_xyz_env.py). A task derives from it and says where
/// its object is, how it is placed and what is rewarded. An episode is a pure function of the
/// placement and the actions: no state of an earlier episode survives Reset. Not thread-safe; one
/// per thread.
class SawyerEnvironment {
 public:
  virtual ~SawyerEnvironment() = default;
  SawyerEnvironment(const SawyerEnvironment&) = delete;
  SawyerEnvironment& operator=(const SawyerEnvironment&) = delete;

  /// Starts an episode at `placement`, which rules it wholly (the official package's frozen
  /// rand_vec semantics). @return the first observation, unclipped as the official one is.
  Observation Reset(const RandVec& placement);
  /// Five physics substeps under `action`. @throws std::logic_error past step 500 or before Reset,
  /// std::invalid_argument if a component is not finite.
  StepResult Step(const Action& action);

  /// As Reset, but never from the shared state after hand initialisation: for tests of it.
  Observation ResetAfresh(const RandVec& placement);

  /// The physics as it stands, for measurements; valid as long as the environment.
  [[nodiscard]] const mjModel& model() const { return *model_; }
  [[nodiscard]] const mjData& data() const { return *data_; }

  /// Takes over what the recorded environment remembered of its reset. Call Reset first.
  /// @throws std::invalid_argument if a name or a size does not fit the scene.
  void Replay(const RecordedStart& start);
  /// Observation, reward and info in a recorded state: no physics step, only mj_forward.
  /// @param step  that it is the state after, from 1.
  /// @throws std::invalid_argument if a size does not fit the scene.
  StepResult ReplayStep(const RecordedState& state, const Action& action, int step);

 protected:
  SawyerEnvironment(const TaskSpec& task, const EnvironmentOptions& options);

  /// Puts the scene's fixed bodies where `placement` wants them (MoveBody), before physics runs.
  /// These are all the model edits that matter to physics.
  virtual void EditModel(const RandVec& /*placement*/) {}
  /// Places the object after the hand initialisation and sets `target_` and `object_init_`.
  /// Positions read at its start lag one physics step behind, as in the official environment; where
  /// that one ends its reset without mj_forward, so does this, and the first observation shows
  /// them so.
  virtual void PlaceObject(const RandVec& placement) = 0;
  [[nodiscard]] virtual ObjectPose Object() const = 0;
  [[nodiscard]] virtual ObjectPose SecondObject() const { return {}; }
  /// @param observation  as returned, that is clipped. @param action  as given.
  virtual Outcome Evaluate(const Observation& observation, const Action& action) = 0;

  // For constructors: a number that the official task remembers of its reset under the attribute
  // `name`. A replay takes it from the recording.
  void Remember(const char* name, double* number) { remembered_[name] = {number, 1}; }
  void Remember(const char* name, Eigen::Vector3d* vector) {
    remembered_[name] = {vector->data(), 3};
  }

  // For EditModel and PlaceObject.
  void MoveBody(int body, const Eigen::Vector3d& position);  // in its parent
  /// Only for pictures: the mark of a goal.
  void MoveSite(int site, const Eigen::Vector3d& position);  // in its body
  /// Joint positions from `address` on; velocities are kept, kinematics are not computed.
  void SetQpos(int address, std::initializer_list<double> numbers);
  /// `count` joint velocities from `address` on become 0.
  void Stop(int address, int count);
  void Forward();  // mj_forward
  /// Official `_set_obj_xyz` of tasks with a free joint after the arm (qpos 9, qvel 9): moves it,
  /// keeps its orientation, stops it, mj_forward.
  void SetFreeObject(const Eigen::Vector3d& position);
  /// One control interval of physics: 5 x mj_step.
  void Substeps();

  [[nodiscard]] Scalar Caging(const Eigen::Vector3d& object, const CagingShape& shape,
                              float gripper) const;
  /// The scene around an object as caging rewards see it.
  [[nodiscard]] CagingState CagingAt(const Eigen::Vector3d& object) const;
  /// Whether both pads press on the geom: the sums of their contacts' normal forces are positive.
  [[nodiscard]] bool Pinched(int geom) const;

  // Indices by name, for constructors. @throws std::runtime_error if the scene has no such thing.
  [[nodiscard]] int Body(const char* name) const { return Find(mjOBJ_BODY, name); }
  [[nodiscard]] int Site(const char* name) const { return Find(mjOBJ_SITE, name); }
  [[nodiscard]] int Geom(const char* name);  // whose pose is kept from then on
  /// Index in qpos of a joint's first number.
  [[nodiscard]] int Joint(const char* name) const {
    return model_->jnt_qposadr[Find(mjOBJ_JOINT, name)];
  }

  [[nodiscard]] Eigen::Vector3d BodyPosition(int body) const { return At3(data_->xpos, body); }
  [[nodiscard]] Eigen::Vector3d SitePosition(int site) const { return At3(data_->site_xpos, site); }
  [[nodiscard]] Eigen::Vector3d GeomPosition(int geom) const { return At3(data_->geom_xpos, geom); }
  /// (w, x, y, z).
  [[nodiscard]] Eigen::Vector4d BodyQuaternion(int body) const;
  /// (x, y, z, w), of the rotation matrix.
  [[nodiscard]] Eigen::Vector4d BodyMatrixQuaternion(int body) const;
  [[nodiscard]] Eigen::Vector4d SiteQuaternion(int site) const;
  [[nodiscard]] Eigen::Vector4d GeomQuaternion(int geom) const;
  [[nodiscard]] Eigen::Vector3d Tcp() const;  // mean of the two finger tips
  [[nodiscard]] Eigen::Vector3d LeftPad() const { return BodyPosition(left_pad_); }
  [[nodiscard]] const Eigen::Vector3d& HandInit() const { return task_.hand.initial; }

  static Eigen::Vector3d At3(const double* numbers, int index) {
    return Eigen::Map<const Eigen::Vector3d>(numbers + 3 * index);
  }

  const std::shared_ptr<engine::Scene> scene_;
  engine::PlacedModel model_;
  const engine::DataPtr data_;
  Eigen::Vector3d target_ = Eigen::Vector3d::Zero();       // goal position
  Eigen::Vector3d object_init_ = Eigen::Vector3d::Zero();  // object's place after reset
  Eigen::Vector3d tcp_init_ = Eigen::Vector3d::Zero();     // finger tips after hand initialisation

 private:
  using Frame = std::array<double, kFrameSize>;

  [[nodiscard]] int Find(mjtObj type, const char* name) const;
  [[nodiscard]] double NormalForce(int pad, int geom) const;
  void InitialiseHand(mjData& data);
  Observation FinishReset(const RandVec& placement);
  [[nodiscard]] Frame CurrentFrame() const;
  Observation Observe(const Frame& previous) const;
  void Clip(Observation& observation) const;
  void MoveMocap(const Action& action);
  StepResult Conclude(const Action& action);

  const TaskSpec& task_;
  const EnvironmentOptions options_;
  const Box goal_box_;
  engine::ControlStepper stepper_;
  std::map<std::string, std::span<double>> remembered_;  // by official attribute
  int mocap_ = 0;
  int hand_, right_claw_, left_claw_, right_pad_, left_pad_;  // bodies
  int right_tip_, left_tip_;                                  // sites
  int right_pad_geom_, left_pad_geom_;
  Frame previous_frame_{};
  int steps_ = kMaxSteps;  // none left before the first reset
};

/// A task's factory, for its row.
template <class Task>
std::unique_ptr<SawyerEnvironment> Make(const TaskSpec& task, const EnvironmentOptions& options) {
  return std::make_unique<Task>(task, options);
}
/// The same for a class that several tasks share, each with settings of its own.
template <class Task, const auto& kSettings>
std::unique_ptr<SawyerEnvironment> Make(const TaskSpec& task, const EnvironmentOptions& options) {
  return std::make_unique<Task>(task, options, kSettings);
}

/// The goal box of tasks that have none of their own, officially: the hand's.
/// @param floor  of that hand's box, metres.
inline Box HandBox(double floor = 0.05) { return {{-0.5, 0.4, floor}, {0.5, 1, 0.5}}; }

}  // namespace metronome::metaworld
