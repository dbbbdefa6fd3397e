#pragma once

namespace metronome::metaworld::engine {

/// On MuJoCo 2.2.2, makes welds with a torque scale the constraint that 3.3.0 makes of them, for
/// every model and mjData of the process: 2.2.2 applies the scale to the Jacobian only, neither to
/// the rotational residual nor to the rows' regularisation. Does nothing on other engines.
/// Sets mjcb_control; call once. The callback reads and writes its own mjModel and mjData alone, so
/// any number of threads may step.
void InstallWeldCorrection();

}  // namespace metronome::metaworld::engine
