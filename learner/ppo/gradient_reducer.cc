#include "learner/ppo/gradient_reducer.h"

#include <algorithm>
#include <cmath>

namespace metronome::ppo {
namespace {

constexpr std::size_t kSlice = 4096;  // parameters per task

}  // namespace

ShardGroups ShardGroups::Of(std::size_t shards) {
  return {shards, std::max<std::size_t>(1, (shards + kMostGroups - 1) / kMostGroups)};
}

std::size_t ShardGroups::end(std::size_t group) const { return std::min(begin(group + 1), shards); }

GradientReducer::GradientReducer(std::size_t groups, std::size_t parameters, WorkerTeam& team)
    : of_group_(groups, std::vector<float>(parameters)), sum_(parameters), team_(team) {}

double GradientReducer::Reduce(std::size_t groups) {
  const std::size_t slices = (sum_.size() + kSlice - 1) / kSlice;
  std::vector<double> squares(slices, 0);
  team_.Run(slices, [&](std::size_t slice) {
    const std::size_t begin = slice * kSlice;
    const std::size_t end = std::min(begin + kSlice, sum_.size());
    std::copy(of_group_[0].data() + begin, of_group_[0].data() + end, sum_.data() + begin);
    for (std::size_t g = 1; g < groups; ++g) {
      const float* gradient = of_group_[g].data();
      for (std::size_t i = begin; i < end; ++i) sum_[i] += gradient[i];
    }
    for (std::size_t i = begin; i < end; ++i) squares[slice] += double{sum_[i]} * sum_[i];
  });
  double sum = 0;
  for (const double square : squares) sum += square;
  return std::sqrt(sum);
}

}  // namespace metronome::ppo
