#pragma once

#include <google/protobuf/repeated_ptr_field.h>

#include <vector>

#include "common/checkpoint/repeated_field.h"
#include "common/policy/running_statistics.h"

namespace metronome::checkpoint {

/// Statistics, one a task, as they lie in a message of a checkpoint: `Payload` has mean, m2, count.
template <typename Payload>
void ToField(const std::vector<policy::RunningStatistics>& statistics,
             google::protobuf::RepeatedPtrField<Payload>& field) {
  for (const policy::RunningStatistics& of_task : statistics) {
    Payload& payload = *field.Add();
    payload.mutable_mean()->Assign(of_task.mean.begin(), of_task.mean.end());
    payload.mutable_m2()->Assign(of_task.m2.begin(), of_task.m2.end());
    payload.set_count(of_task.count);
  }
}

template <typename Payload>
std::vector<policy::RunningStatistics> StatisticsOf(
    const google::protobuf::RepeatedPtrField<Payload>& field) {
  std::vector<policy::RunningStatistics> statistics;
  for (const Payload& payload : field) {
    statistics.push_back({FromField(payload.mean()), FromField(payload.m2()), payload.count()});
  }
  return statistics;
}

}  // namespace metronome::checkpoint
