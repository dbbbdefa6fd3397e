#pragma once

#include "actor/metaworld/sawyer.h"

/// What tasks with a window share.
namespace metronome::metaworld::tasks::windows {

inline constexpr double kNearRadius = 0.02;  // that counts as at the handle, metres

struct WindowSettings {
  const char* handle;  // site that is observed and pushed
  double start;        // of the slide, metres: 0 shut, 0.2 open
  bool from_handle;    // whether the way to go counts from the handle, not the window
  double (*near)(double distance, double margin);  // of the finger tips to the handle
};

class Window final : public SawyerEnvironment {
 public:
  Window(const TaskSpec& task, const EnvironmentOptions& options, const WindowSettings& settings);

 private:
  void EditModel(const RandVec& p) override { MoveBody(window_, ObjectOf(p)); }
  void PlaceObject(const RandVec& p) override;
  [[nodiscard]] ObjectPose Object() const override { return {.position = SitePosition(handle_)}; }
  Outcome Evaluate(const Observation& observation, const Action& action) override;

  const WindowSettings& settings_;
  int window_, slide_, handle_, goal_;
  Eigen::Vector3d handle_init_ = Eigen::Vector3d::Zero();
};

}  // namespace metronome::metaworld::tasks::windows
