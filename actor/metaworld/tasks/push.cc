#include <cmath>

#include "actor/metaworld/sawyer.h"

/// Push a puck to a goal on the table. As metaworld 3.1.1 has it: envs/sawyer_push_v3.py.
namespace metronome::metaworld::tasks {
namespace {

constexpr CagingShape kCaging = {
    .object_radius = 0.015, .pad_success = 0.05, .xz_threshold = 0.005};

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

class Push final : public SawyerEnvironment {
 public:
  Push(const TaskSpec& task, const EnvironmentOptions& options)
      : SawyerEnvironment(task, options, {{0, 0.6, 0.2}, {-0.5, 0.4, 0.05}, {0.5, 1, 0.5}, true}),
        object_(Body("obj")),
        object_geom_(Geom("objGeom")),
        left_pad_geom_(Geom("leftpad_geom")),
        right_pad_geom_(Geom("rightpad_geom")),
        goal_(Site("goal")) {}

 private:
  void EditModel(const RandVec&) override {}

  void PlaceObject(const RandVec& p) override {
    const double height = BodyPosition(object_).z();  // as the puck has settled
    object_init_ = {p[0], p[1], height};
    target_ = {p[3], p[4], height};
    Eigen::Map<Eigen::Vector3d>(model_->site_pos + 3 * goal_) = target_;
    SetObject(object_init_);
  }

  [[nodiscard]] ObjectPose Object() const override {
    return {BodyPosition(object_), QuaternionXyzw(data_->geom_xmat + 9 * object_geom_)};
  }

  Outcome Evaluate(const Observation& observation, const Action& action) override {
    const Eigen::Vector3d object = At3(observation.data() + 4, 0);
    const double opening = observation[3];
    const double tcp_to_object = Norm(object - Tcp());
    const double to_target = Norm(object - target_);
    const double in_place = LongTail(to_target, 0, 0.05, Norm(object_init_ - target_));
    const Scalar grasp = Caging(object, kCaging, action[3]);

    Scalar reward = 2 * grasp;
    if (tcp_to_object < 0.02 && opening > 0) reward = reward + (1 + reward + 5 * in_place);
    if (to_target < 0.05) reward = 10;
    const bool grasped = Pinched() && opening > 0 && object.z() - 0.02 > object_init_.z();
    return {reward.value(),
            {.success = to_target <= 0.05,
             .near_object = tcp_to_object <= 0.03 ? 1.0 : 0.0,
             .grasp_success = grasped ? 1.0 : 0.0,
             .grasp_reward = grasp.value(),
             .in_place_reward = in_place,
             .obj_to_target = to_target}};
  }

  [[nodiscard]] bool Pinched() const {
    return NormalForce(left_pad_geom_) > 0 && NormalForce(right_pad_geom_) > 0;
  }

  /// Sum of the normal contact forces between `pad` and the puck, newton.
  [[nodiscard]] double NormalForce(int pad) const {
    double force = 0;
    for (int i = 0; i < data_->ncon; ++i) {
      const mjContact& contact = data_->contact[i];
      const bool both = (contact.geom1 == pad && contact.geom2 == object_geom_) ||
                        (contact.geom2 == pad && contact.geom1 == object_geom_);
      if (both && contact.efc_address >= 0) force += data_->efc_force[contact.efc_address];
    }
    return force;
  }

  int object_, object_geom_, left_pad_geom_, right_pad_geom_, goal_;
};

}  // namespace

std::unique_ptr<SawyerEnvironment> MakePush(const TaskSpec& task,
                                            const EnvironmentOptions& options) {
  return std::make_unique<Push>(task, options);
}

}  // namespace metronome::metaworld::tasks
