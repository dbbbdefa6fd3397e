#pragma once

#include <string>

/// Identity of the build that computed a number: shown, recorded in checkpoints, and named where
/// one at joining is refused. Thread-safe.
namespace metronome::process {

/// The physics that this binary was built against, e.g. "mujoco-2.2.2". Runs never mix engines.
std::string EngineName();

/// The project's version, and everything outside the sources that may change a floating-point bit:
/// compiler, its flags, Eigen (the policy's sums and tanh), the C library that is loaded, e.g.
/// "metronome 0.2.0, gcc 12.2.0, -O3 -DNDEBUG -march=x86-64-v3 -ffp-contract=off, eigen 3.4.0,
/// glibc 2.36". For people: nothing is refused because of it.
std::string BuildIdentity();

}  // namespace metronome::process
