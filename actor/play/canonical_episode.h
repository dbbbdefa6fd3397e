#pragma once

#include <string>

#include "actor/environment/registry.h"

namespace metronome::play {

/// The digest that two hosts must agree on to play the same episodes: two hex SHA-256 one after
/// the other:
/// - of the environment: 100 steps of `task` (of each, one after the other, where it names several)
/// at a fixed start (the next one where it ends) under fixed pseudo-random actions
///   (observations and rewards as float32), and the C library's elementary functions, which engines
///   call. Checkpoints of older builds hold it alone: it must not change while the bits do not;
/// - of the policy: decisions of a network of the task's sizes and fixed pseudo-random weights,
///   whose sums and tanh are those of common/kernels/, by whatever instructions.
/// A pure function of the task, the engine, SLEEF and the C library, whose variant depends on
/// whether the processor has FMA. About 0.1 s a task, and the scenes' loading time.
/// @throws as EnvironmentRegistry::Make.
std::string CanonicalDigest(const environment::EnvironmentRegistry& registry,
                            const std::string& task);

}  // namespace metronome::play
