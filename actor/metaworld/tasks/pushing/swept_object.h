#pragma once

#include "actor/metaworld/tasks/pushing/pushed_object.h"

/// What sweep and sweep-into share: their reward.
namespace metronome::metaworld::tasks::pushing {

class SweptObject : public PushedObject {
 protected:
  SweptObject(const TaskSpec& task, const EnvironmentOptions& options,
              const PushedSettings& settings, const SignedCagingShape& caging, double grip_success)
      : PushedObject(task, options, settings), caging_(caging), grip_success_(grip_success) {}

 private:
  [[nodiscard]] Reward RewardOf(const Moment& now, float /*gripper*/) const final {
    const double in_place = LongTail(now.to_target, 0, 0.05, Norm(object_init_ - now.target));
    const double grasp = SignedGrasp(CagingAt(now.object), caging_, grip_success_);
    const Scalar reward = 2 * grasp + 6 * Hamacher(grasp, in_place);
    return {now.to_target < kNear ? 10 : reward, grasp, in_place};
  }

  const SignedCagingShape caging_;
  const double grip_success_;  // metres
};

}  // namespace metronome::metaworld::tasks::pushing
