#include "actor/metaworld/placement.h"

#include <cmath>

namespace metronome::metaworld {
namespace {

bool Accepted(const TaskSpec& task, const RandVec& p) {
  const Eigen::Vector2d from = task.keep_from.value_or(Eigen::Vector2d(p[3], p[4]));
  const double dx = p[0] - from.x(), dy = p[1] - from.y();
  return !(std::sqrt(dx * dx + dy * dy) < task.min_planar_distance);
}

/// @param uniform  callable, the next number in [0, 1). One is drawn per component even where the
///                 box is flat, as numpy does.
template <class Uniform>
RandVec Draw(const TaskSpec& task, Uniform& uniform) {
  RandVec p{};
  do {
    for (int i = 0; i < task.placement_size; ++i)
      p[i] = task.low[i] + (task.high[i] - task.low[i]) * uniform();
  } while (!Accepted(task, p));
  return p;
}

/// numpy.random.RandomState's random_sample(): a 32-bit Mersenne twister, 53-bit uniforms.
double LegacyNumpyUniform(std::mt19937& twister) {
  const std::uint32_t high = twister() >> 5, low = twister() >> 6;
  return (high * 67108864.0 + low) / 9007199254740992.0;  // (high * 2^26 + low) / 2^53
}

}  // namespace

RandVec DrawPlacement(const TaskSpec& task, numbers::RandomStream& stream) {
  auto uniform = [&stream] { return stream.Uniform(); };
  return Draw(task, uniform);
}

std::vector<RandVec> OfficialPlacements::Next(const TaskSpec& task) {
  auto uniform = [this] { return LegacyNumpyUniform(twister_); };
  std::vector<RandVec> placements(kMt1Placements);
  for (RandVec& placement : placements) {
    Draw(task, uniform);  // the first of the reset's two passes, overwritten by the second
    placement = Draw(task, uniform);
  }
  return placements;
}

std::vector<RandVec> Mt1Placements(const TaskSpec& task, std::uint32_t seed) {
  return OfficialPlacements(seed).Next(task);
}

const RandVec& PickOfficial(const std::vector<RandVec>& official,
                            environment::EpisodeStart& start) {
  return official.at(start.key.purpose == numbers::RandomPurpose::kTrain
                         ? start.random.Below(official.size())
                         : start.key.number % official.size());
}

RandVec StartPlacement(const TaskSpec& task, Placements placements,
                       environment::EpisodeStart& start) {
  if (placements != PLACEMENTS_MT1) return DrawPlacement(task, start.random);
  return PickOfficial(Mt1Placements(task, static_cast<std::uint32_t>(start.key.seed)), start);
}

}  // namespace metronome::metaworld
