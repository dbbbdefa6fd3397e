#include "actor/play/training_differences.h"

#include <numeric>
#include <utility>

#include "common/config/config_fields.h"
#include "common/process/build_info.h"
#include "common/text/near_miss.h"

namespace metronome::play {
namespace {

using Sentences = std::vector<std::string>;

/// Placements that the seed chooses.
bool AreOfficial(const EnvironmentConfig& environment) {
  return environment.placements() == PLACEMENTS_MT1 ||
         environment.placements() == PLACEMENTS_BENCHMARK;
}

/// The options that give the placements of training.
std::string PlacementOptions(const RunConfig& trained) {
  const EnvironmentConfig& environment = trained.environment();
  std::string words =
      "--placements " +
      config::FieldText(environment, *environment.GetDescriptor()->FindFieldByName("placements"));
  if (AreOfficial(environment)) {
    words += " --seed " + std::to_string(trained.seed());
  }
  return words;
}

void AddEnvironment(const RunConfig& trained, const RunConfig& played, Sentences& sentences) {
  std::vector<std::string> before;
  config::VisitFields(trained.environment(),
                      [&](const auto&, const auto& owner, const auto& field) {
                        before.push_back(config::FieldText(owner, field));
                      });
  std::size_t index = 0;
  config::VisitFields(
      played.environment(), [&](const std::string& name, const auto& owner, const auto& field) {
        const std::string& was = before.at(index++);
        const std::string is = config::FieldText(owner, field);
        // A task's own numbers go without saying.
        if (was == is || name.starts_with("spec.")) return;
        std::string sentence =
            "trained with " + name + " " + was + ", evaluated with " + name + " " + is;
        if (name == "placements") {
          sentence += " (as in training: " + PlacementOptions(trained) + ")";
        }
        sentences.push_back(std::move(sentence));
      });
}

void AddSeed(const RunConfig& trained, const EvaluateOptions& options, const RunConfig& played,
             Sentences& sentences) {
  const Placements placements = trained.environment().placements();
  const bool same =
      AreOfficial(trained.environment()) && played.environment().placements() == placements;
  if (!same || options.seed == trained.seed()) return;
  const std::string seed = std::to_string(trained.seed());
  sentences.push_back(std::string("trained on the ") +
                      (placements == PLACEMENTS_MT1 ? "mt1" : "benchmark") +
                      " placements of seed " + seed + ", evaluated on those of seed " +
                      std::to_string(options.seed) + " (as in training: --seed " + seed + ")");
}

/// Heads that act in blocks do so in the order 0, 1, ...
bool IsOwnOrder(const std::vector<std::uint32_t>& order, const RunConfig& trained) {
  std::vector<std::uint32_t> own(order.size());
  std::iota(own.begin(), own.end(), 0U);
  return order == own && trained.policy().schedule() == SCHEDULE_BLOCKS;
}

void AddHeadOrder(const RunConfig& trained, const std::vector<std::uint32_t>& order,
                  Sentences& sentences) {
  if (order.empty() || IsOwnOrder(order, trained)) return;
  std::vector<std::string> words;
  words.reserve(order.size());
  for (const std::uint32_t head : order) words.push_back(std::to_string(head));
  sentences.push_back(std::string("trained with ") +
                      (trained.policy().schedule() == SCHEDULE_BLOCKS
                           ? "heads in their own blocks of time"
                           : "heads in a permutation drawn for each episode") +
                      ", evaluated with heads in the order " + text::JoinNames(words));
}

/// "glibc 2.36" of a BuildIdentity, say; empty: it does not name that part.
std::string PartOf(const std::string& identity, const std::string& name) {
  const std::size_t at = identity.find(", " + name + ' ');
  if (at == std::string::npos) return "";
  const std::size_t begin = at + 2;
  return identity.substr(begin, identity.find(", ", begin) - begin);
}

/// Of libraries that can change a bit, where both builds name theirs: not all always did. Not
/// versions of this project: CHANGELOG.md names the few that change one.
void AddLibraries(const std::string& trained, const std::string& used, Sentences& sentences) {
  for (const char* library : {"sleef", "glibc"}) {
    const std::string before = PartOf(trained, library);
    const std::string now = PartOf(used, library);
    if (before.empty() || now.empty() || before == now) continue;
    std::string sentence = "trained with ";
    sentence.append(before).append(", evaluated with ").append(now);
    sentences.push_back(std::move(sentence));
  }
}

}  // namespace

std::vector<std::string> DifferencesFromTraining(const checkpoint::Checkpoint& checkpoint,
                                                 const EvaluateOptions& options,
                                                 const RunConfig& played) {
  const RunConfig& trained = checkpoint.config;
  Sentences sentences;
  AddEnvironment(trained, played, sentences);
  AddSeed(trained, options, played, sentences);
  AddHeadOrder(trained, options.head_order, sentences);
  if (checkpoint.engine != process::EngineName()) {
    sentences.push_back("trained on " + checkpoint.engine + ", evaluated on " +
                        process::EngineName());
  }
  AddLibraries(checkpoint.build, process::BuildIdentity(), sentences);
  return sentences;
}

}  // namespace metronome::play
