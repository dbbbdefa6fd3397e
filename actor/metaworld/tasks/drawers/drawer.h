#pragma once

#include "actor/metaworld/sawyer.h"

/// What tasks with a drawer share.
namespace metronome::metaworld::tasks::drawers {

class Drawer : public SawyerEnvironment {
 protected:
  /// @param handle  seen from the drawer's origin, metres.
  Drawer(const TaskSpec& task, const EnvironmentOptions& options, const Eigen::Vector3d& handle)
      : SawyerEnvironment(task, options),
        handle_(handle),
        case_(Body("drawer")),
        drawer_(Body("drawer_link")),
        slide_(Joint("goal_slidey")),
        goal_(Site("goal")) {}

  void EditModel(const RandVec& p) override { MoveBody(case_, ObjectOf(p)); }
  [[nodiscard]] Eigen::Vector3d Handle() const { return BodyPosition(drawer_) + handle_; }

  const Eigen::Vector3d handle_;
  int case_, drawer_, slide_, goal_;
};

}  // namespace metronome::metaworld::tasks::drawers
