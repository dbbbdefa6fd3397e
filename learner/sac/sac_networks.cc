#include "learner/sac/sac_networks.h"

#include <vector>

namespace metronome::sac {

SacNetworks::SacNetworks(const RunConfig& config)
    : shape(policy::ShapeOf(config)),
      actor(policy::ActorLayout(shape)),
      bins(std::size_t(config.sac().bins())) {
  const std::vector<std::int32_t> hidden(config.sac().critic_hidden().begin(),
                                         config.sac().critic_hidden().end());
  critic = policy::LayoutOf(std::int32_t(critic_inputs()), hidden, shape.critic_heads,
                            std::int32_t(bins));
  critic.normalised = config.sac().critic_norm();
}

}  // namespace metronome::sac
