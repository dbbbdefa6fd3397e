#pragma once

namespace metronome::sac {

/// Sums over a head's samples.
struct HeadSums {
  double samples = 0;
  double entropy = 0;  // minus log-density of the actions tried, nats
  double value = 0;    // of these actions, in symlog
};

}  // namespace metronome::sac
