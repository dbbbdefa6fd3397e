#include <cmath>

#include "actor/metaworld/sawyer.h"

/// Put a wrench's ring over a peg. As metaworld 3.1.1 has it: envs/sawyer_assembly_peg_v3.py.
namespace metronome::metaworld::tasks {
namespace {

constexpr CagingShape kCaging = {.object_radius = 0.015,
                                 .pad_success = 0.02,
                                 .xz_threshold = 0.01,
                                 .density = CagingDensity::kMedium};
const Eigen::Vector4d kUpright(0.707, 0, 0, 0.707);  // quaternion (w, x, y, z) of a flat wrench

struct Placed {
  double reward = 0;
  bool success = false;
};

/// How near the ring's centre is to sitting on the peg, by a funnel over the peg.
Placed RewardPlace(const Eigen::Vector3d& ring, const Eigen::Vector3d& target) {
  Eigen::Vector3d error = target - ring;
  const double radius = Norm(error.head<2>());
  const bool success = radius < 0.02 && error.z() > 0;
  const double threshold = success ? 0.02 : 0.01;
  const double height = radius > threshold ? 0.02 * std::log(radius - threshold) + 0.2 : 0;
  error.z() = (height - ring.z()) * 3;
  const bool lifted = ring.z() > 0.02 || radius < threshold;
  return {0.1 * (lifted ? 1 : 0) + 0.9 * LongTail(Norm(error), 0, 0.02, 0.4), success};
}

class Assembly final : public SawyerEnvironment {
 public:
  Assembly(const TaskSpec& task, const EnvironmentOptions& options)
      // The official task keeps the initial hand position in float32.
      : SawyerEnvironment(task, options, {{0, 0.6F, 0.2F}, {-0.5, 0.4, 0.05}, {0.5, 1, 0.5}, true}),
        nut_(Body("RoundNut")),
        peg_(Body("peg")),
        handle_(Site("RoundNut-8")),
        ring_(Site("RoundNut")),
        peg_top_(Site("pegTop")) {}

 private:
  void EditModel(const RandVec& p) override {
    Eigen::Map<Eigen::Vector3d>(model_->body_pos + 3 * peg_) =
        Goal(p) - Eigen::Vector3d(0, 0, 0.05);
    // A position in the peg's frame, hence in a wrong place of the world: as official, and
    // harmless.
    Eigen::Map<Eigen::Vector3d>(model_->site_pos + 3 * peg_top_) = Goal(p);
  }

  void PlaceObject(const RandVec& p) override {
    object_init_ = {p[0], p[1], p[2]};
    target_ = Goal(p);
    SetObject(object_init_);
  }

  static Eigen::Vector3d Goal(const RandVec& p) { return {p[3], p[4], p[5]}; }

  [[nodiscard]] ObjectPose Object() const override {
    return {SitePosition(handle_), BodyQuaternion(nut_)};
  }

  Outcome Evaluate(const Observation& observation, const Action& action) override {
    const double hand_x = observation[0];
    Eigen::Vector3d wrench = At3(observation.data() + 4, 0);
    // Caging takes the object for a ball; along the handle any place is as good.
    if (std::abs(wrench.x() - hand_x) < 0.01) wrench.x() = hand_x;
    const Eigen::Vector4d quaternion = Eigen::Map<const Eigen::Vector4d>(observation.data() + 7);
    const double upright = std::max(1 - Norm(quaternion - kUpright) / 0.4, 0.0);
    const Scalar grasp = Caging(wrench, kCaging, action[3]);
    const Placed placed = RewardPlace(SitePosition(ring_), target_);

    Scalar reward = (2 * grasp + 6 * placed.reward) * upright;
    if (placed.success) reward = 10;
    return {reward.value(),
            {.success = placed.success,
             .near_object = upright,
             .grasp_success = grasp.value() >= 0.5 ? 1.0 : 0.0,
             .grasp_reward = grasp.value(),
             .in_place_reward = placed.reward,
             .obj_to_target = 0}};
  }

  int nut_, peg_, handle_, ring_, peg_top_;
};

}  // namespace

std::unique_ptr<SawyerEnvironment> MakeAssembly(const TaskSpec& task,
                                                const EnvironmentOptions& options) {
  return std::make_unique<Assembly>(task, options);
}

}  // namespace metronome::metaworld::tasks
