#include "learner/ppo/ppo_algorithm.h"
#include "learner/program.h"

int main(int argc, char** argv) {
  return metronome::learner::LearnerProgram(argc, argv,
                                            {{"ppo", metronome::ppo::MakePpoFactory()}});
}
