#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "common/kernels/matrix.h"
#include "common/messages/messages.h"
#include "common/policy/network_input.h"
#include "common/policy/packed_network.h"
#include "common/schema/config.pb.h"
#include "learner/sac/sac_networks.h"
#include "learner/sac/transition.h"

namespace metronome::sac {

/// What actor and critics see of a batch, a sample a row. Rows may be gathered side by side.
class BatchRows {
 public:
  /// @param config  resolved.
  explicit BatchRows(const RunConfig& config);

  /// Both stay alive while the batch is in work. @param batch  sorted as DrawBatch does, sac.batch
  /// samples.
  void Take(const std::vector<Transition>& batch, const PolicySnapshot& normaliser);

  /// Writes the row's inputs, all but the actions that the policy tries.
  void Gather(std::size_t row);
  /// Writes the action that the policy tries in the row's state, or in its next state.
  void Try(std::size_t row, const float* action);
  void TryNext(std::size_t row, const float* action);

  [[nodiscard]] std::size_t size() const { return samples_; }
  [[nodiscard]] const Transition& of(std::size_t row) const { return (*batch_)[row]; }
  /// Heads of rows [first, first + count): of their states, or of their next states.
  [[nodiscard]] std::vector<policy::HeadRun> Runs(std::size_t first, std::size_t count) const;
  [[nodiscard]] std::vector<policy::HeadRun> NextRuns(std::size_t first, std::size_t count) const;

  kernels::Matrix state;  // of the actor
  kernels::Matrix next_state;
  kernels::Matrix played;  // of the critics: the state with the action that was played
  kernels::Matrix tried;   // with the action that the policy tries
  kernels::Matrix next;    // the next state with the action that the policy tries there

 private:
  void WriteState(const ReplayEpisode& of, std::int32_t t, float* actor_row, float* critic_row);
  [[nodiscard]] std::vector<policy::HeadRun> RunsOf(std::size_t first, std::size_t count,
                                                    std::int32_t Transition::*head) const;

  SacNetworks networks_;
  std::int32_t horizon_;
  float clip_;
  std::size_t samples_;
  const std::vector<Transition>* batch_ = nullptr;
  policy::Normaliser normaliser_{};
};

}  // namespace metronome::sac
