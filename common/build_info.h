#pragma once

#include <string>

/// Who computed a number: shown, recorded in checkpoints, and compared at joining. Thread-safe.
namespace metronome {

/// The physics that this binary was built against, e.g. "mujoco-2.2.2". Runs never mix engines.
std::string EngineName();

/// Everything outside the sources that may change a floating-point bit: compiler, its flags, the
/// C library that is loaded, e.g. "metronome 0.1.0, gcc 12.2.0, -O3 -DNDEBUG -march=x86-64-v3
/// -ffp-contract=off, glibc 2.36".
std::string BuildIdentity();

/// "0.1.0": the project's version alone.
std::string ProjectVersion();

}  // namespace metronome
