#include "actor/play/training_differences.h"

#include <algorithm>
#include <map>
#include <numeric>
#include <string_view>

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

/// The parts of a BuildIdentity by what they are of, "glibc" to "glibc 2.36" say; compilers are of
/// "gcc", flags of "-".
std::map<std::string, std::string> PartsOf(std::string_view identity) {
  std::map<std::string, std::string> parts;
  while (!identity.empty()) {
    const std::string_view part = identity.substr(0, identity.find(", "));
    std::string_view of = part.substr(0, part.starts_with('-') ? 1 : part.find(' '));
    if (of == "clang") of = "gcc";
    parts[std::string(of)] = part;
    identity.remove_prefix(std::min(identity.size(), part.size() + 2));
  }
  return parts;
}

/// Builds did not always name all of their parts: those that both name are compared. Not versions
/// of this project: CHANGELOG.md names the few that change a bit.
void AddBuild(const std::string& trained, const std::string& used, Sentences& sentences) {
  std::vector<std::string> before;
  std::vector<std::string> now;
  const auto parts = PartsOf(used);
  for (const auto& [of, part] : PartsOf(trained)) {
    const auto other = parts.find(of);
    if (of == "metronome" || other == parts.end() || other->second == part) continue;
    before.push_back(part);
    now.push_back(other->second);
  }
  if (before.empty()) return;
  sentences.push_back("trained by a build of " + text::JoinNames(before) +
                      ", evaluated by one of " + text::JoinNames(now));
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
  AddBuild(checkpoint.build, process::BuildIdentity(), sentences);
  return sentences;
}

}  // namespace metronome::play
