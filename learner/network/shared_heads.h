#pragma once

#include <cstddef>
#include <vector>

#include "common/policy/network.h"
#include "learner/network/adam.h"

namespace metronome::network {

/// Heads that learn from each other: besides its own gradient each head follows the sum of all
/// heads' gradients, so that what one block of time learns all blocks have, and what sets a head
/// apart from the heads' mean fades where its own samples do not keep it up. These are the
/// parameters w_0 + v_t of regularised multi-task learning (Evgeniou, Pontil, KDD 2004,
/// section 2.1), a task a head, with w_0 in the heads themselves. Weights and biases; actor
/// and critic apart. Log-stds are each head's own: with shared ones the first head that has learnt
/// its block ends the search of those that have not. A network with one head has nothing to share.
class SharedHeads {
 public:
  /// Adam's moments of the shared gradient, [size()] each, network by network.
  struct Moments {
    std::vector<float> m;
    std::vector<float> v;
    bool operator==(const Moments&) const = default;
  };

  /// @param networks  whose parameters lie one behind the other.
  explicit SharedHeads(const std::vector<policy::MlpLayout>& networks);
  /// Of PPO's actor and critic.
  explicit SharedHeads(const policy::NetworkShape& shape)
      : SharedHeads({policy::ActorLayout(shape), policy::CriticLayout(shape)}) {}

  /// Floats of a shared gradient: one head's of each network.
  [[nodiscard]] std::size_t size() const { return size_; }

  /// Gives all heads the parameters of the first.
  void MakeEqual(std::vector<float>& parameters) const;

  /// After the heads' own step: the shared one, then w_j -= decay * (w_j - mean of all w).
  /// @param gradient, parameters  flat, of all networks. @param decay  from 0 to 1.
  void Step(const Adam& adam, const float* gradient, float decay, Moments& moments,
            float* parameters) const;

 private:
  /// Equal pieces of a flat vector, a head each.
  struct Pieces {
    std::size_t first = 0;
    std::size_t size = 0;
    std::size_t heads = 0;
  };

  void AddNetwork(const policy::MlpLayout& layout, std::size_t offset);

  std::vector<Pieces> pieces_;
  std::size_t size_ = 0;
};

}  // namespace metronome::network
