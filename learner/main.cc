#include "learner/ppo/ppo_algorithm.h"
#include "learner/program.h"

int main(int argc, char** argv) {
  return metronome::LearnerProgram(argc, argv, {{"ppo", metronome::MakePpoFactory()}});
}
