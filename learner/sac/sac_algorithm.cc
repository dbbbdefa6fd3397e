#include "learner/sac/sac_algorithm.h"

#include "learner/algorithm/trainer_algorithm.h"
#include "learner/sac/sac_report.h"
#include "learner/sac/sac_state.h"
#include "learner/sac/trainer.h"

namespace metronome::sac {
namespace {

struct Parts {
  static checkpoint::TrainState Encode(const SacState& state, const RunConfig& config) {
    return EncodeSacState(state, config);
  }
  static SacReport BlankReport(std::size_t heads) { return EmptySacReport(heads); }
  static std::vector<algorithm::Metric> MetricsOf(const SacReport& report) {
    return SacMetrics(report);
  }
};

class SacFactory final : public algorithm::AlgorithmFactory {
 public:
  [[nodiscard]] checkpoint::TrainState InitialState(
      const RunConfig& config, const checkpoint::TrainState* source) const override {
    SacState state = InitialSacState(config);
    if (source != nullptr) {
      const SacState other = DecodeSacState(*source, config);
      state.optimiser.actor = other.optimiser.actor;
      state.optimiser.critics = other.optimiser.critics;
      state.optimiser.targets = other.optimiser.targets;
      state.observation = other.observation;
    }
    return EncodeSacState(state, config);
  }
  [[nodiscard]] std::unique_ptr<algorithm::Algorithm> Make(
      const RunConfig& config, const checkpoint::TrainState& state,
      const algorithm::AlgorithmResources& resources) const override {
    return std::make_unique<algorithm::TrainerAlgorithm<Trainer, Parts>>(
        config,
        std::make_unique<Trainer>(config, DecodeSacState(state, config), resources.replay,
                                  resources.threads),
        resources.check_key);
  }
};

}  // namespace

std::shared_ptr<const algorithm::AlgorithmFactory> MakeSacFactory() {
  return std::make_shared<SacFactory>();
}

}  // namespace metronome::sac
