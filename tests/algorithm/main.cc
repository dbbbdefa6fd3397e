// metronome-learner with one more algorithm, for integration/test_algorithms.py.
#include "learner/ppo/ppo_algorithm.h"
#include "learner/program.h"
#include "tests/algorithm/cross_entropy.h"

int main(int argc, char** argv) {
  return metronome::learner::LearnerProgram(
      argc, argv,
      {{"ppo", metronome::ppo::MakePpoFactory()},
       {"cross-entropy", metronome::test::MakeCrossEntropyFactory()}});
}
