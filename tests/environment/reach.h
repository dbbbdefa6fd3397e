#pragma once

#include "actor/environment/registry.h"

namespace metronome::test {

/// A point in the plane that is to come to a goal: an environment that only tests know, as other
/// people's are. Seven observations, two actions, episodes of 5 to 60 steps: the goal ends them
/// (success), so does leaving the arena.
///
/// A step moves the point by at most kStride. It costs 1/60, and pays what it came nearer to the
/// goal; reaching it pays the rest of the way and 1. All is divided by what the straight way at
/// full stride would bring, which is the most: the best possible return is 1, whatever the start.
environment::EnvironmentEntry Reach();

}  // namespace metronome::test
