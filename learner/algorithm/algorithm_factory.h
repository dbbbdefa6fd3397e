#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <stdexcept>
#include <string>
#include <vector>

#include "common/checkpoint/train_state.h"
#include "common/messages/episode.h"
#include "common/schema/config.pb.h"
#include "learner/algorithm/algorithm.h"

namespace metronome::algorithm {

/// The algorithm cannot go on from a state: of a format that this build does not know, or of
/// another shape than the configuration's. what() does not name the file.
class UnusableState : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// Resources that a learner gives its algorithm; none of them changes the result.
struct AlgorithmResources {
  int threads = 1;              // of an update, at least 1
  std::uint64_t check_key = 0;  // see CheckEpisode
  /// Of a state that is gone on from: the replay's episodes, in number order.
  std::vector<Episode> replay = {};
};

/// Makes one kind of algorithm. Free of state.
class AlgorithmFactory {
 public:
  virtual ~AlgorithmFactory() = default;

  /// Version 0 of a run. @param config  resolved.
  /// @param source  what the run begins with the weights and observation statistics of, or null:
  ///                of the same algorithm and network shape.
  /// @throws UnusableState for `source`, std::invalid_argument if the algorithm's own settings
  ///         cannot be as they are.
  [[nodiscard]] virtual checkpoint::TrainState InitialState(
      const RunConfig& config, const checkpoint::TrainState* source) const = 0;
  /// The algorithm at `state`. @throws UnusableState, std::invalid_argument as above.
  [[nodiscard]] virtual std::unique_ptr<Algorithm> Make(
      const RunConfig& config, const checkpoint::TrainState& state,
      const AlgorithmResources& resources) const = 0;
};

/// The algorithms that a learner's program knows, by the names of their configuration.
using Algorithms = std::map<std::string, std::shared_ptr<const AlgorithmFactory>>;

/// That of the configuration. @throws std::invalid_argument naming those that there are.
const AlgorithmFactory& FactoryOf(const Algorithms& algorithms, const RunConfig& config);

/// @throws UnusableState unless the state is the algorithm's and of a format from 1 to `newest`.
void RequireFormat(const checkpoint::AlgorithmState& state, const std::string& name,
                   std::uint32_t newest);

}  // namespace metronome::algorithm
