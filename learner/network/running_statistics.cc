#include "learner/network/running_statistics.h"

#include <cmath>
#include <stdexcept>

namespace metronome::network {

void Merge(policy::RunningStatistics& statistics, const float* values, std::size_t rows,
           std::size_t dimensions, std::size_t stride) {
  if (statistics.mean.empty()) {
    statistics.mean.assign(dimensions, 0);
    statistics.m2.assign(dimensions, 0);
  }
  if (statistics.mean.size() != dimensions || statistics.m2.size() != dimensions) {
    throw std::invalid_argument("running statistics have another dimension than the values");
  }
  if (rows == 0) return;
  const auto n = static_cast<double>(rows);
  const double total = statistics.count + n;
  for (std::size_t i = 0; i < dimensions; ++i) {
    double sum = 0;
    for (std::size_t r = 0; r < rows; ++r) sum += values[r * stride + i];
    const double mean = sum / n;
    double m2 = 0;
    for (std::size_t r = 0; r < rows; ++r) {
      const double deviation = values[r * stride + i] - mean;
      m2 += deviation * deviation;
    }
    const double delta = mean - statistics.mean[i];
    statistics.mean[i] += delta * n / total;
    statistics.m2[i] += m2 + delta * delta * statistics.count * n / total;
  }
  statistics.count = total;
}

void Decay(policy::RunningStatistics& statistics, double factor) {
  statistics.count *= factor;
  for (double& m2 : statistics.m2) m2 *= factor;
}

double StandardDeviation(const policy::RunningStatistics& statistics, std::size_t dimension) {
  if (statistics.count == 0) return 1;
  return std::sqrt(statistics.m2.at(dimension) / statistics.count);
}

}  // namespace metronome::network
