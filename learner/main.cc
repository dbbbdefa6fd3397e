#include "learner/ppo/ppo_algorithm.h"
#include "learner/program.h"
#include "learner/sac/sac_algorithm.h"

int main(int argc, char** argv) {
  return metronome::learner::LearnerProgram(
      argc, argv,
      {{"ppo", metronome::ppo::MakePpoFactory()}, {"sac", metronome::sac::MakeSacFactory()}});
}
