#include "learner/algorithm/algorithm_factory.h"

#include <vector>

#include "common/config/config.h"
#include "common/text/near_miss.h"

namespace metronome::algorithm {

const AlgorithmFactory& FactoryOf(const Algorithms& algorithms, const RunConfig& config) {
  const std::string name = config::AlgorithmName(config);
  if (const auto found = algorithms.find(name); found != algorithms.end()) return *found->second;
  std::vector<std::string> known;
  known.reserve(algorithms.size());
  for (const auto& [other, factory] : algorithms) known.push_back(other);
  throw std::invalid_argument("this learner has no such algorithm: " +
                              text::UnknownName("algorithm", name, known));
}

void RequireFormat(const checkpoint::AlgorithmState& state, const std::string& name,
                   std::uint32_t newest) {
  if (state.name != name) {
    throw UnusableState("its state is of the algorithm " + state.name + ", this run's is " + name);
  }
  if (state.format >= 1 && state.format <= newest) return;
  throw UnusableState("its state of " + name + " has format " + std::to_string(state.format) +
                      ", this build reads formats 1 to " + std::to_string(newest) +
                      "; use a build that knows it");
}

}  // namespace metronome::algorithm
