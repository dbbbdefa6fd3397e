#include "common/policy/activation.h"

namespace metronome {

void TanhInPlace(Eigen::MatrixXf& values) { values = values.array().tanh(); }

}  // namespace metronome
