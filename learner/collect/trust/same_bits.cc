#include "learner/collect/trust/same_bits.h"

#include <cstring>
#include <vector>

namespace metronome::collect::trust {
namespace {

template <class T>
bool SameBytes(const std::vector<T>& a, const std::vector<T>& b) {
  return a.size() == b.size() &&
         (a.empty() || std::memcmp(a.data(), b.data(), a.size() * sizeof(T)) == 0);
}

}  // namespace

bool SameBits(const Episode& a, const Episode& b) {
  return a.number == b.number && a.weights_version == b.weights_version &&
         SameBytes(a.observation, b.observation) && SameBytes(a.action, b.action) &&
         SameBytes(a.log_prob, b.log_prob) && SameBytes(a.reward, b.reward) &&
         SameBytes(a.head, b.head) && SameBytes(a.flags, b.flags);
}

}  // namespace metronome::collect::trust
