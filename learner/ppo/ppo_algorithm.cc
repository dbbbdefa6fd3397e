#include "learner/ppo/ppo_algorithm.h"

#include "learner/algorithm/trainer_algorithm.h"
#include "learner/ppo/ppo_report.h"
#include "learner/ppo/ppo_state.h"
#include "learner/ppo/trainer.h"

namespace metronome::ppo {
namespace {

struct Parts {
  static checkpoint::TrainState Encode(const PpoState& state, const RunConfig& config) {
    return EncodePpoState(state, config);
  }
  static PpoReport BlankReport(std::size_t heads) { return EmptyPpoReport(heads); }
  static std::vector<algorithm::Metric> MetricsOf(const PpoReport& report) {
    return PpoMetrics(report);
  }
};

class PpoFactory final : public algorithm::AlgorithmFactory {
 public:
  [[nodiscard]] checkpoint::TrainState InitialState(
      const RunConfig& config, const checkpoint::TrainState* source) const override {
    PpoState state = Trainer::InitialState(config);
    if (source != nullptr) {
      const PpoState other = DecodePpoState(*source, config);
      state.parameters = other.parameters;
      state.observation = other.observation;
    }
    return EncodePpoState(state, config);
  }
  [[nodiscard]] std::unique_ptr<algorithm::Algorithm> Make(
      const RunConfig& config, const checkpoint::TrainState& state,
      const algorithm::AlgorithmResources& resources) const override {
    return std::make_unique<algorithm::TrainerAlgorithm<Trainer, Parts>>(
        config, std::make_unique<Trainer>(config, DecodePpoState(state, config), resources.threads),
        resources.check_key);
  }
};

}  // namespace

std::shared_ptr<const algorithm::AlgorithmFactory> MakePpoFactory() {
  return std::make_shared<PpoFactory>();
}

}  // namespace metronome::ppo
