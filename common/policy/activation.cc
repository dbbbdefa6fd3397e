#include "common/policy/activation.h"

namespace metronome::policy {

void TanhInPlace(Eigen::MatrixXf& values) { values = values.array().tanh(); }

}  // namespace metronome::policy
