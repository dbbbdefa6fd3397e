#pragma once

#include <mujoco/mujoco.h>

#include <array>

namespace metronome::environment {

/// The points that a picture's path follows, in metres.
struct Landmarks {
  std::array<double, 3> hand{};
  std::array<double, 3> object{};
  double gripper = 0;  // 0 closed, 1 open
};

/// Where a free camera stands: metres and degrees; azimuth 90 looks away from the robot's base.
struct CameraView {
  std::array<double, 3> look_at{};
  double distance = 1;
  double azimuth = 90;
  double elevation = -25;
};

/// An environment in MuJoCo, for those who draw it; valid as long as the environment.
class MujocoView {
 public:
  virtual ~MujocoView() = default;
  [[nodiscard]] virtual const mjModel& model() const = 0;
  [[nodiscard]] virtual const mjData& data() const = 0;
  [[nodiscard]] virtual Landmarks landmarks() const = 0;      // as the last observation shows them
  [[nodiscard]] virtual CameraView view() const = 0;          // that shows what matters
  [[nodiscard]] virtual double steps_per_second() const = 0;  // in real time
};

}  // namespace metronome::environment
