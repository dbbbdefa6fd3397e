#pragma once

#include <Eigen/Core>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "actor/metaworld/engine/control_step.h"
#include "actor/metaworld/engine/engine.h"
#include "actor/metaworld/reward_terms.h"
#include "actor/metaworld/step_result.h"
#include "actor/metaworld/task_spec.h"

namespace metronome::metaworld {

inline constexpr int kFrameSize = 18;  // hand 3, gripper 1, object 3 + 4, a second object's 7 zeros

/// A task's robot; everything else about it is the same in all scenes.
struct HandSettings {
  Eigen::Vector3d initial;    // where the mocap body waits during the hand initialisation, metres
  Eigen::Vector3d low, high;  // box that the mocap body is kept in, metres
  /// Whether the state after the hand initialisation is the same for every placement in the task's
  /// box: no body that a placement moves can touch what moves by then.
  bool settles_alike;
};

/// Where and how the manipulated object is, as the observation shows it.
struct ObjectPose {
  Eigen::Vector3d position;
  Eigen::Vector4d quaternion;  // (w, x, y, z) of a body, (x, y, z, w) of a geom's matrix, by task
};

struct Outcome {
  double reward = 0;
  StepInfo info;
};

/// The beginning of a recorded episode, as far as a replay needs it.
struct RecordedStart {
  Observation observation{};
  Eigen::Vector3d goal;
  std::map<std::string, std::vector<double>> internals;  // official attribute names
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
  /// @throws std::invalid_argument if a size does not fit the scene.
  StepResult ReplayStep(const RecordedState& state, const Action& action);

 protected:
  SawyerEnvironment(const TaskSpec& task, const EnvironmentOptions& options,
                    const HandSettings& hand);

  /// Puts the scene's fixed bodies where `placement` wants them, before physics runs. These are all
  /// the model edits that matter to physics.
  virtual void EditModel(const RandVec& placement) = 0;
  /// Places the object after the hand initialisation, sets `target_` and `object_init_`, and ends
  /// with consistent kinematics. Positions read at its start still lag one physics step behind,
  /// as in the official environment.
  virtual void PlaceObject(const RandVec& placement) = 0;
  [[nodiscard]] virtual ObjectPose Object() const = 0;
  /// @param observation  as returned, that is clipped. @param action  as given.
  virtual Outcome Evaluate(const Observation& observation, const Action& action) = 0;

  /// Official `_set_obj_xyz`: moves the free joint, keeps its orientation, stops it, mj_forward.
  void SetObject(const Eigen::Vector3d& position);
  /// One control interval of physics: 5 x mj_step.
  void Substeps();
  [[nodiscard]] Scalar Caging(const Eigen::Vector3d& object, const CagingShape& shape,
                              float gripper) const;

  // Indices by name, for constructors. @throws std::runtime_error if the scene has no such thing.
  [[nodiscard]] int Body(const char* name) const { return Find(mjOBJ_BODY, name); }
  [[nodiscard]] int Site(const char* name) const { return Find(mjOBJ_SITE, name); }
  [[nodiscard]] int Geom(const char* name) const { return Find(mjOBJ_GEOM, name); }

  [[nodiscard]] Eigen::Vector3d BodyPosition(int body) const { return At3(data_->xpos, body); }
  [[nodiscard]] Eigen::Vector3d SitePosition(int site) const { return At3(data_->site_xpos, site); }
  [[nodiscard]] Eigen::Vector4d BodyQuaternion(int body) const;
  [[nodiscard]] Eigen::Vector3d Tcp() const;  // mean of the two finger tips

  static Eigen::Vector3d At3(const double* numbers, int index) {
    return Eigen::Map<const Eigen::Vector3d>(numbers + 3 * index);
  }

  const std::shared_ptr<engine::Scene> scene_;
  const engine::ModelPtr model_;
  const engine::DataPtr data_;
  Eigen::Vector3d target_ = Eigen::Vector3d::Zero();       // goal position
  Eigen::Vector3d object_init_ = Eigen::Vector3d::Zero();  // object's place after reset
  Eigen::Vector3d tcp_init_ = Eigen::Vector3d::Zero();     // finger tips after hand initialisation

 private:
  using Frame = std::array<double, kFrameSize>;

  [[nodiscard]] int Find(mjtObj type, const char* name) const;
  void InitialiseHand(engine::ControlStepper& stepper, const mjModel& model, mjData& data) const;
  Observation FinishReset(const RandVec& placement);
  [[nodiscard]] Frame CurrentFrame() const;
  Observation Observe(const Frame& previous) const;
  void Clip(Observation& observation) const;
  void MoveMocap(const Action& action);
  StepResult Conclude(const Action& action);

  const TaskSpec& task_;
  const EnvironmentOptions options_;
  const HandSettings hand_settings_;
  engine::ControlStepper stepper_;
  int mocap_ = 0;
  int hand_, right_claw_, left_claw_, right_pad_, left_pad_;  // bodies
  int right_tip_, left_tip_;                                  // sites
  Frame previous_frame_{};
  int steps_ = kMaxSteps;  // none left before the first reset
};

}  // namespace metronome::metaworld
