#include "actor/actor_program.h"
#include "actor/metaworld/tasks/environments.h"

/// The environments that metronome-actor plays: to add a family, add its table here.
int main(int argc, char** argv) {
  const metronome::environment::EnvironmentRegistry registry(
      metronome::metaworld::tasks::Environments(), metronome::metaworld::tasks::RequireScenes,
      metronome::metaworld::tasks::Groups());
  return metronome::actor::RunActorProgram(argc, argv, registry);
}
