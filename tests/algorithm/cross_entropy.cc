#include "tests/algorithm/cross_entropy.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <numeric>
#include <stdexcept>

#include "common/policy/network.h"
#include "common/policy/snapshot.h"
#include "common/process/sha256.h"
#include "learner/algorithm/episode_checker.h"

namespace metronome::test {
namespace {

constexpr char kName[] = "cross-entropy";
constexpr std::uint32_t kFormat = 1;  // the policy's parameters as they lie in memory

class CrossEntropy final : public algorithm::Algorithm {
 public:
  CrossEntropy(const RunConfig& config, const checkpoint::TrainState& state,
               std::uint64_t check_key)
      : config_(config),
        layout_(policy::ActorLayout(policy::ShapeOf(config))),
        counters_(state),
        parameters_(layout_.size),
        best_(std::stoul(config.custom().settings())),
        checker_(config, check_key) {
    algorithm::RequireFormat(state.algorithm, kName, kFormat);
    if (state.algorithm.bytes.size() != parameters_.size() * sizeof(float)) {
      throw algorithm::UnusableState("its state of the cross-entropy method has another shape");
    }
    std::memcpy(parameters_.data(), state.algorithm.bytes.data(), state.algorithm.bytes.size());
  }

  [[nodiscard]] const checkpoint::RunCounters& counters() const override { return counters_; }

  algorithm::UpdateReport Update(const std::vector<Episode>& batch) override {
    std::vector<double> returns;
    returns.reserve(batch.size());
    for (const Episode& episode : batch) {
      returns.push_back(std::accumulate(episode.reward.begin(), episode.reward.end(), 0.0));
    }
    std::vector<std::size_t> order(batch.size());
    std::iota(order.begin(), order.end(), 0U);
    std::stable_sort(order.begin(), order.end(),
                     [&](std::size_t a, std::size_t b) { return returns[a] > returns[b]; });
    order.resize(std::min(best_, order.size()));
    for (std::int32_t head = 0; head < layout_.heads; ++head) {
      for (std::int32_t i = 0; i < layout_.head_outputs; ++i) Refit(batch, order, head, i);
    }
    counters_ = algorithm::CountersAfter(counters_, batch);
    algorithm::UpdateReport report = algorithm::ReportOf(config_, counters_, batch);
    report.metrics = Metrics();
    report.metrics.front().value = returns[order.front()];
    return report;
  }

  [[nodiscard]] checkpoint::TrainState State() const override {
    checkpoint::TrainState state;
    static_cast<checkpoint::RunCounters&>(state) = counters_;
    state.policy = Snapshot();
    state.weights = {parameters_.size(), process::WeightsSha256(parameters_)};
    state.algorithm = {kName, kFormat,
                       std::string(reinterpret_cast<const char*>(parameters_.data()),
                                   parameters_.size() * sizeof(float))};
    return state;
  }
  [[nodiscard]] PolicySnapshot Snapshot() const override {
    return policy::MakeSnapshot(counters_.version, parameters_.data(), {}, config_);
  }
  [[nodiscard]] PolicySnapshot PreviousSnapshot() const override {
    throw std::logic_error("the cross-entropy method does not overlap");
  }
  [[nodiscard]] std::optional<std::string> Check(const Episode& episode,
                                                 const PolicySnapshot& snapshot) const override {
    return checker_.Check(episode, snapshot);
  }
  [[nodiscard]] std::vector<algorithm::Metric> Metrics() const override {
    return {{"best_return", "cross_entropy/best_return", 0.0, "return of the best episode"}};
  }

 private:
  /// Component i of a head's action, from its steps in the best episodes.
  void Refit(const std::vector<Episode>& batch, const std::vector<std::size_t>& best,
             std::int32_t head, std::int32_t i) {
    std::vector<double> actions;
    for (const std::size_t e : best) {
      for (std::size_t t = 0; t < batch[e].head.size(); ++t) {
        if (batch[e].head[t] != head) continue;
        actions.push_back(batch[e].action[t * std::size_t(layout_.head_outputs) + std::size_t(i)]);
      }
    }
    if (actions.empty()) return;
    const auto n = double(actions.size());
    const double mean = std::accumulate(actions.begin(), actions.end(), 0.0) / n;
    double variance = 0;
    for (const double action : actions) variance += (action - mean) * (action - mean) / n;
    const std::size_t at = std::size_t(head) * std::size_t(layout_.head_outputs) + std::size_t(i);
    parameters_[layout_.head.bias + at] = float(mean);
    parameters_[layout_.log_std + at] = float(std::log(std::sqrt(variance) + 0.1));
  }

  RunConfig config_;
  policy::MlpLayout layout_;
  checkpoint::RunCounters counters_;
  std::vector<float> parameters_;  // of the policy
  std::size_t best_;
  mutable algorithm::EpisodeChecker checker_;
};

class CrossEntropyFactory final : public algorithm::AlgorithmFactory {
 public:
  [[nodiscard]] checkpoint::TrainState InitialState(
      const RunConfig& config, const checkpoint::TrainState* source) const override {
    if (config.collection().overlap() > 0) throw std::invalid_argument("collection.overlap: not 0");
    const policy::MlpLayout layout = policy::ActorLayout(policy::ShapeOf(config));
    checkpoint::TrainState state;
    state.algorithm = {kName, kFormat, std::string(layout.size * sizeof(float), '\0')};
    if (source != nullptr) state.algorithm = source->algorithm;
    return CrossEntropy(config, state, 0).State();
  }
  [[nodiscard]] std::unique_ptr<algorithm::Algorithm> Make(
      const RunConfig& config, const checkpoint::TrainState& state,
      const algorithm::AlgorithmResources& resources) const override {
    return std::make_unique<CrossEntropy>(config, state, resources.check_key);
  }
};

}  // namespace

std::shared_ptr<const algorithm::AlgorithmFactory> MakeCrossEntropyFactory() {
  return std::make_shared<CrossEntropyFactory>();
}

}  // namespace metronome::test
