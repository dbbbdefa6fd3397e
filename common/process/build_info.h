#pragma once

#include <string>

/// Identity of the build that computed a number: shown, recorded in checkpoints, and named where
/// one at joining is refused. Thread-safe.
namespace metronome::process {

/// The physics that this binary was built against, e.g. "mujoco-2.2.2". Runs never mix engines.
std::string EngineName();

/// For people: nothing is refused because of it. First what can decide a bit of a result beside the
/// engine, the project's version; then what cannot, but helps where something is slow or broken,
/// the compiler and its flags; then libraries that can: SLEEF (our elementary functions), and the
/// loaded C library (the engine's). E.g. "metronome 0.2.0, gcc 12.2.0, -O3 -DNDEBUG
/// -march=x86-64-v3 -ffp-contract=off, sleef 3.5.1, glibc 2.36".
std::string BuildIdentity();

}  // namespace metronome::process
