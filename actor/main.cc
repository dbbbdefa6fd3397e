#include "actor/actor_program.h"
#include "actor/metaworld/tasks/environments.h"

/// The environments that metronome-actor plays: to add a family, add its table here.
int main(int argc, char** argv) {
  const metronome::EnvironmentRegistry registry(metronome::metaworld::Environments(),
                                                metronome::metaworld::RequireScenes);
  return metronome::RunActorProgram(argc, argv, registry);
}
