#include "actor/metaworld/reward_terms.h"

#include <cmath>

#include "common/numbers/elementary.h"

namespace metronome::metaworld {
namespace {

double XzNorm(const Eigen::Vector3d& v) { return Norm(Eigen::Vector2d(v.x(), v.z())); }

/// One pad's share: near the object in y, with a margin that moves with the pad.
double PadCaging(double pad_y, const CagingState& state, const CagingShape& shape) {
  const double margin = std::abs(std::abs(pad_y - state.object_init.y()) - shape.pad_success);
  return LongTail(std::abs(pad_y - state.object.y()), shape.object_radius, shape.pad_success,
                  margin);
}

}  // namespace

double LongTail(double x, double low, double high, double margin) {
  if (low <= x && x <= high) return 1;
  if (margin == 0) return 0;
  const double d = (x < low ? low - x : x - high) / margin * 3;
  return 1 / (d * d + 1);
}

double Gaussian(double x, double high, double margin) {
  if (0 <= x && x <= high) return 1;
  if (margin == 0) return 0;
  constexpr double kOneTenth = 2.145966026289347;  // sqrt(-2 ln 0.1): the value at the margin
  const double d = (x < 0 ? -x : x - high) / margin * kOneTenth;
  return numbers::Exp(-0.5 * (d * d));
}

Scalar Hamacher(Scalar a, Scalar b) {
  const Scalar product = a * b;
  const Scalar denominator = a + b - product;
  return denominator.value() > 0 ? product / denominator : Scalar(0);
}

Scalar ClosedExtent(float gripper, double effort) {
  if (!(gripper > 0)) return 0.0;
  if (static_cast<float>(effort) < gripper) return 1.0;
  return Scalar::Single(gripper) / effort;
}

Scalar Caging(const CagingState& state, const CagingShape& shape, float gripper) {
  const Scalar y = Hamacher(PadCaging(state.left_pad_y, state, shape),
                            PadCaging(state.right_pad_y, state, shape));
  const double xz = LongTail(XzNorm(state.tcp - state.object), 0, shape.xz_threshold,
                             XzNorm(state.object_init - state.tcp_init) - shape.xz_threshold);
  const Scalar caging = Hamacher(y, xz);
  const Scalar closed = caging.value() > 0.97 ? ClosedExtent(gripper, shape.effort) : Scalar(0);
  const Scalar both = Hamacher(caging, closed);
  if (shape.density == CagingDensity::kPlain) return both;
  if (shape.density == CagingDensity::kHigh) return (both + caging) / 2;
  const double margin = std::abs(Norm(state.object_init - state.tcp_init) - shape.reach_radius);
  return (both + LongTail(Norm(state.object - state.tcp), 0, shape.reach_radius, margin)) / 2;
}

namespace {

/// Of both pads: their signed distances to the object's side, within radius and radius + `reach`.
Scalar SignedPads(const CagingState& state, double radius, double high) {
  constexpr double kPadsApart = 0.05;  // metres
  const auto pad = [&](double distance) {
    return LongTail(distance, radius, high, std::abs(std::abs(distance) - kPadsApart));
  };
  return Hamacher(pad(state.object.y() - state.right_pad_y),
                  pad(state.left_pad_y - state.object.y()));
}

}  // namespace

double SignedCaging(const CagingState& state, const SignedCagingShape& shape) {
  const double xz = LongTail(XzNorm(state.tcp - state.object), 0, shape.xz_threshold,
                             XzNorm(state.object_init - state.tcp_init) - shape.xz_threshold);
  return Hamacher(SignedPads(state, shape.object_radius, 0.05), xz).value();
}

double SignedGrasp(const CagingState& state, const SignedCagingShape& shape, double grip_success) {
  const double caging = SignedCaging(state, shape);
  const double high = shape.object_radius + grip_success;
  const double grip = caging > 0.95 ? SignedPads(state, shape.object_radius, high).value() : 0;
  return (caging + grip) / 2;
}

}  // namespace metronome::metaworld
