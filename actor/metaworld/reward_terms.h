#pragma once

#include <Eigen/Core>
#include <cmath>

/// The reward's building blocks, as metaworld 3.1.1 has them: utils/reward_utils.py, and
/// _gripper_caging_reward of sawyer_xyz_env.py. Pure functions.
namespace metronome::metaworld {

/// A number under numpy's promotion rules (NEP 50): once a float32 action enters a formula, all
/// that follows with Python floats is rounded to float32. Rewards agree with the official ones to
/// the bit only if they round where those do.
class Scalar {
 public:
  Scalar(double value) : value_(value) {}  // NOLINT(google-explicit-constructor): a Python float
  static Scalar Single(float value) { return {value, true}; }

  [[nodiscard]] double value() const { return value_; }

  friend Scalar operator+(Scalar a, Scalar b) {
    return Apply(a, b, [](auto x, auto y) { return x + y; });
  }
  friend Scalar operator-(Scalar a, Scalar b) {
    return Apply(a, b, [](auto x, auto y) { return x - y; });
  }
  friend Scalar operator*(Scalar a, Scalar b) {
    return Apply(a, b, [](auto x, auto y) { return x * y; });
  }
  friend Scalar operator/(Scalar a, Scalar b) {
    return Apply(a, b, [](auto x, auto y) { return x / y; });
  }

 private:
  Scalar(double value, bool single) : value_(value), single_(single) {}

  template <class Operation>
  static Scalar Apply(Scalar a, Scalar b, Operation operation) {
    if (!a.single_ && !b.single_) return operation(a.value_, b.value_);
    return Single(operation(static_cast<float>(a.value_), static_cast<float>(b.value_)));
  }

  double value_;
  bool single_ = false;
};

/// 1 where low <= x <= high, else 1 / ((3 d / margin)^2 + 1) at distance d from the nearer bound
/// (0.1 at d = margin), else 0 where margin is 0. @param margin  not negative.
double LongTail(double x, double low, double high, double margin);

/// The same with a gaussian tail beyond `high`, from 0 on: exp(-0.5 (d/margin sqrt(-2 ln 0.1))^2),
/// 0.1 at d = margin, 0 where margin is 0.
double Gaussian(double x, double high, double margin);

/// Hamacher product a b / (a + b - a b), 0 where the denominator is not positive. In [0, 1] for
/// arguments in [0, 1].
Scalar Hamacher(Scalar a, Scalar b);

/// The inputs of a caging reward from the scene, in metres.
struct CagingState {
  double left_pad_y, right_pad_y;
  Eigen::Vector3d tcp, object;            // now
  Eigen::Vector3d tcp_init, object_init;  // after reset
};

enum class CagingDensity {
  kPlain,   // the gripper's share alone
  kHigh,    // its mean with the caging
  kMedium,  // its mean with how near the finger tips are
};

/// Constants of a task's caging reward.
struct CagingShape {
  double object_radius, pad_success, xz_threshold;  // metres
  double effort = 1;                                // gripper command that counts as closed
  CagingDensity density = CagingDensity::kHigh;
  double reach_radius = 0.01;  // metres, of kMedium
};

/// clamp(gripper, 0, effort) / effort, in float32 unless a bound replaces the command.
Scalar ClosedExtent(float gripper, double effort);

/// Reward for having the object between the pads and the gripper closed, in [0, 1].
/// @param gripper  action[3] as given, not clipped.
Scalar Caging(const CagingState& state, const CagingShape& shape, float gripper);

/// Constants of the caging rewards that some tasks have of their own: distances of the pads are
/// signed, and their margins move with pads and object (the official attributes init_left_pad and
/// init_right_pad are views of the pads as they are now).
struct SignedCagingShape {
  double object_radius, xz_threshold;  // metres
};

/// How well the object is between the pads, in [0, 1], without the gripper: the first half of
/// sweep's, sweep-into's, soccer's, push-back's and pick-place's.
double SignedCaging(const CagingState& state, const SignedCagingShape& shape);

/// The same with the share of a grasp, of pads within `grip_success` (metres) of the object's side,
/// where caging is above 0.95; their mean. sweep, sweep-into, soccer, push-back.
double SignedGrasp(const CagingState& state, const SignedCagingShape& shape, double grip_success);

/// Euclidean length, summed in order with fused multiply-adds: as numpy's linear algebra does on
/// the processors that we build for, hence equal to the official numbers to the bit.
template <class Vector>
double Norm(const Eigen::MatrixBase<Vector>& v) {
  double sum = 0;
  for (Eigen::Index i = 0; i < v.size(); ++i) sum = std::fma(v[i], v[i], sum);
  return std::sqrt(sum);
}

}  // namespace metronome::metaworld
