#include "common/config/config.h"

#include <google/protobuf/text_format.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <map>
#include <stdexcept>

#include "common/policy/task_of.h"

namespace metronome::config {
namespace {

constexpr std::int32_t kDefaultHeads = 10;
constexpr std::int32_t kDefaultWidth = 128;
constexpr std::int32_t kDefaultCriticWidth = 128;  // of SAC, as the next two
constexpr std::int32_t kDefaultSacEpisodes = 4;    // an update
constexpr std::uint64_t kDefaultSacSteps = 2000000;
constexpr std::int64_t kDefaultMinibatch = 2000;

/// Where the first value of `group` came from; nullptr: nobody set one.
const std::string* OriginOfGroup(const ConfigOrigins& origins, const std::string& group) {
  const auto first = origins.lower_bound(group + ".");
  return first != origins.end() && first->first.starts_with(group + ".") ? &first->second : nullptr;
}

void RequireNotBoth(const ParsedConfig& parsed, const std::string& group,
                    const ConfigOrigins& origins, const std::string& other) {
  const std::string* here = OriginOfGroup(parsed.origins, group);
  const std::string* before = OriginOfGroup(origins, other);
  if (here == nullptr || before == nullptr) return;
  throw ConfigError(*here + ": " + group + " is set, and " + other + " at " + *before +
                    ": a run learns by one of the two");
}

/// A file's algorithm would replace an earlier file's without a word.
void RequireSameAlgorithm(const ParsedConfig& parsed, const ConfigOrigins& origins) {
  constexpr std::array kAlgorithms = {"ppo", "sac", "custom"};
  for (const std::string group : kAlgorithms) {
    for (const std::string other : kAlgorithms) {
      if (group != other) RequireNotBoth(parsed, group, origins, other);
    }
  }
}

}  // namespace

RunConfig Resolve(RunConfig config) {
  const bool batch_given = config.collection().has_episodes_per_update();
  if (config.has_sac()) {
    // Actors go on while the learner learns, and what they play is learnt from soon.
    auto& collection = *config.mutable_collection();
    if (!collection.has_overlap()) collection.set_overlap(1);
    if (!batch_given) collection.set_episodes_per_update(kDefaultSacEpisodes);
    if (!config.has_total_steps()) config.set_total_steps(kDefaultSacSteps);
  }
  FillDefaults(config);
  auto& environment = *config.mutable_environment();
  if (environment.spec().name().empty()) environment.clear_spec();
  if (!environment.has_horizon()) environment.set_horizon(environment.spec().max_steps());
  auto& policy = *config.mutable_policy();
  if (!policy.has_heads()) {
    const bool by_time = policy.method() == MULTIHEAD && policy.heads_by() != HEADS_BY_TASK;
    policy.set_heads(by_time ? kDefaultHeads : 1);
  }
  if (!batch_given) {
    auto& collection = *config.mutable_collection();
    const auto tasks = static_cast<std::int32_t>(policy::TaskCount(config));
    collection.set_episodes_per_update((collection.episodes_per_update() + tasks - 1) / tasks *
                                       tasks);
  }
  if (policy.hidden_size() == 0) {
    for (int layer = 0; layer < 2; ++layer) policy.add_hidden(kDefaultWidth);
  }
  if (config.has_sac() && config.sac().critic_hidden_size() == 0) {
    for (int layer = 0; layer < 2; ++layer) {
      config.mutable_sac()->add_critic_hidden(kDefaultCriticWidth);
    }
  }
  if (config.has_ppo() && !config.ppo().has_minibatch()) {
    const std::int64_t batch = std::int64_t{config.collection().episodes_per_update()} *
                               environment.horizon() * (1 + config.ppo().earlier_batches());
    config.mutable_ppo()->set_minibatch(
        static_cast<std::int32_t>(std::clamp<std::int64_t>(batch, 1, kDefaultMinibatch)));
  }
  return config;
}

std::string PrintConfig(const RunConfig& config) {
  std::string text;
  google::protobuf::TextFormat::PrintToString(config, &text);
  return text;
}

std::vector<std::string> CompareForResume(const RunConfig& old_config, const RunConfig& new_config,
                                          bool new_total_allowed) {
  std::vector<std::string> differences;
  if (const std::string before = AlgorithmName(old_config), now = AlgorithmName(new_config);
      before != now) {
    differences.push_back("the algorithm: the run has " + before + ", asked for " + now);
  }
  std::map<std::string, std::string> old_values;
  VisitFields(old_config, [&](const std::string& path, const auto& owner, const auto& field) {
    old_values[path] = FieldText(owner, field);
  });
  VisitFields(new_config, [&](const std::string& path, const auto& owner, const auto& field) {
    const auto old_value = old_values.find(path);
    if (old_value == old_values.end()) return;  // of another algorithm
    const std::string& before = old_value->second;
    const std::string now = FieldText(owner, field);
    if (before == now || path.starts_with("runtime.")) return;
    const bool total = path == "total_steps";
    if (total && new_total_allowed) return;
    differences.push_back(
        path + ": the run has " + (before.empty() ? "none" : before) + ", asked for " +
        (now.empty() ? "none" : now) +
        (total ? " (the learning rate depends on it; --new-total allows it)" : ""));
  });
  return differences;
}

std::string AlgorithmName(const RunConfig& config) {
  if (config.has_custom()) return config.custom().name();
  return config.has_sac() ? "sac" : "ppo";
}

void CheckRunName(const std::string& name) {
  const auto letter = [](char c) { return std::isalnum(static_cast<unsigned char>(c)) != 0; };
  const bool right = !name.empty() && name.size() <= 64 && letter(name.front()) &&
                     std::all_of(name.begin(), name.end(), [&](char c) {
                       return letter(c) || c == '.' || c == '_' || c == '-';
                     });
  if (right) return;
  throw ConfigError("run name \"" + name +
                    "\": must be 1 to 64 letters, digits, '.', '_' or '-', the first a letter or "
                    "digit (it names a folder and a DDS partition)");
}

void ConfigDraft::ReadFile(const std::string& path) {
  const ParsedConfig parsed = ParseConfigFile(path);
  RequireSameAlgorithm(parsed, origins_);
  Overlay(config_, parsed.config);
  for (const auto& [field, origin] : parsed.origins) origins_[field] = origin;
}

void ConfigDraft::ChooseAlgorithm(const std::string& name, const std::string& origin) {
  if (config_.algorithm_case() != RunConfig::ALGORITHM_NOT_SET) {
    if (AlgorithmName(config_) == name) return;
    throw ConfigError(origin + " " + name + ": the configuration has settings of " +
                      AlgorithmName(config_) + ", and a run learns by one algorithm");
  }
  if (name == "ppo") {
    config_.mutable_ppo();
  } else if (name == "sac") {
    config_.mutable_sac();
  } else {
    config_.mutable_custom()->set_name(name);
  }
}

void ConfigDraft::SetFromArgument(const std::string& argument) {
  const std::size_t equals = argument.find('=');
  if (equals == std::string::npos || equals == 0) {
    throw ConfigError("--set " + argument + ": must be NAME=VALUE, e.g. ppo.learning_rate=3e-4");
  }
  Set(argument.substr(0, equals), argument.substr(equals + 1), "--set");
}

void ConfigDraft::Set(const std::string& path, const std::string& value,
                      const std::string& origin) {
  try {
    SetField(config_, path, value);
  } catch (const ConfigError& error) {
    throw ConfigError(origin + ": " + error.what());
  }
  origins_[path] = origin;
}

RunConfig ConfigDraft::Finish(const SpecSource& source) const {
  RunConfig config = config_;
  try {
    CompleteSpec(config, source);
  } catch (const ConfigError& error) {
    const auto origin = origins_.find("environment.task");
    if (origin == origins_.end()) throw;
    throw ConfigError(origin->second + ": " + error.what());
  }
  config = Resolve(std::move(config));
  Validate(config, origins_);
  return config;
}

}  // namespace metronome::config
