#pragma once

#include <google/protobuf/repeated_field.h>

#include <vector>

namespace metronome::checkpoint {

/// A list of numbers as it lies in a message of a checkpoint.
template <typename T>
std::vector<T> FromField(const google::protobuf::RepeatedField<T>& field) {
  return {field.begin(), field.end()};
}

}  // namespace metronome::checkpoint
