#include "actor/metaworld/placement.h"

#include <cmath>
#include <random>

namespace metronome::metaworld {
namespace {

bool Accepted(const TaskSpec& task, const RandVec& p) {
  const double dx = p[0] - p[3], dy = p[1] - p[4];
  return !(std::sqrt(dx * dx + dy * dy) < task.min_planar_distance);
}

/// @param uniform  callable, the next number in [0, 1). One is drawn per component even where the
///                 box is flat, as numpy does.
template <class Uniform>
RandVec Draw(const TaskSpec& task, Uniform& uniform) {
  RandVec p{};
  do {
    for (std::size_t i = 0; i < p.size(); ++i)
      p[i] = task.low[i] + (task.high[i] - task.low[i]) * uniform();
  } while (!Accepted(task, p));
  return p;
}

/// numpy.random.RandomState(seed).random_sample(): a 32-bit Mersenne twister, 53-bit uniforms.
class LegacyNumpyUniform {
 public:
  explicit LegacyNumpyUniform(std::uint32_t seed) : twister_(seed) {}
  double operator()() {
    const std::uint32_t high = twister_() >> 5, low = twister_() >> 6;
    return (high * 67108864.0 + low) / 9007199254740992.0;  // (high * 2^26 + low) / 2^53
  }

 private:
  std::mt19937 twister_;
};

}  // namespace

RandVec DrawPlacement(const TaskSpec& task, numbers::RandomStream& stream) {
  auto uniform = [&stream] { return stream.Uniform(); };
  return Draw(task, uniform);
}

std::vector<RandVec> Mt1Placements(const TaskSpec& task, std::uint32_t seed) {
  LegacyNumpyUniform uniform(seed);
  std::vector<RandVec> placements(kMt1Placements);
  for (RandVec& placement : placements) {
    Draw(task, uniform);  // the first of the reset's two passes, overwritten by the second
    placement = Draw(task, uniform);
  }
  return placements;
}

RandVec StartPlacement(const TaskSpec& task, Placements placements,
                       environment::EpisodeStart& start) {
  if (placements != PLACEMENTS_MT1) return DrawPlacement(task, start.random);
  const std::vector<RandVec> official =
      Mt1Placements(task, static_cast<std::uint32_t>(start.key.seed));
  return official.at(start.key.purpose == numbers::RandomPurpose::kTrain
                         ? start.random.Below(official.size())
                         : start.key.number % official.size());
}

}  // namespace metronome::metaworld
