#include "actor/actor_program.h"
#include "tests/environment/reach.h"

/// An actor program with another table of environments than metronome-actor's.
int main(int argc, char** argv) {
  return metronome::actor::RunActorProgram(
      argc, argv, metronome::environment::EnvironmentRegistry({metronome::test::Reach()}));
}
