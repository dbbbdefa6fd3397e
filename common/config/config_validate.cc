#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <sstream>

#include "common/config/config.h"
#include "common/messages/episode.h"
#include "common/numbers/elementary.h"
#include "common/policy/network.h"
#include "common/text/host_port.h"
#include "common/text/listen_address.h"
#include "common/text/near_miss.h"
#include "common/text/number_text.h"

namespace metronome::config {
namespace {

constexpr double kUnbounded = std::numeric_limits<double>::infinity();
constexpr double kMostTotal = 9007199254740991;         // 2^53 - 1: exact in every double
constexpr std::size_t kMostPolicyParameters = 4000000;  // kMaxParameters of idl/metronome.idl
constexpr std::uint64_t kMostMt1Seed = 4294967295;      // the official generator takes 32 bits

/// The range of one numeric field by itself. A value that is not finite is in none.
struct Range {
  double low = 0;
  double high = kUnbounded;
  bool low_open = false;  // low itself is not allowed
};

const std::map<std::string, Range>& Ranges() {
  static const std::map<std::string, Range> ranges = {
      {"total_steps", {1, kMostTotal}},
      {"environment.horizon", {1, kMaxSteps}},
      {"environment.success_reward", {0, 1e6}},
      {"environment.spec.observation_size", {1, kMaxObservationSize}},
      {"environment.spec.action_size", {1, kMaxActionSize}},
      {"environment.spec.max_steps", {1, kMaxSteps}},
      {"policy.heads", {1, kUnbounded}},
      {"policy.hidden", {1, 4096}},
      // Learning moves it from there: 20 leaves room to where no actor can act
      // (common/policy/snapshot.cc).
      {"policy.initial_log_std", {-20, 20}},
      // Times the largest weight that a snapshot may have (common/policy/snapshot.cc): a finite
      // float32.
      {"policy.observation_clip", {0, 1e9, true}},
      {"policy.observation_epsilon", {1e-16, 1}},
      {"policy.noise_correlation", {0, 0.999}},
      {"ppo.learning_rate", {0, kUnbounded, true}},
      {"ppo.learning_rate_floor", {0, 1}},
      {"ppo.adam_epsilon", {0, kUnbounded, true}},
      {"ppo.epochs", {1, 10000}},
      {"ppo.minibatch", {1, kUnbounded}},
      {"ppo.clip", {0, kUnbounded, true}},
      {"ppo.value_coefficient", {0, kUnbounded}},
      {"ppo.discount", {0, 1}},
      {"ppo.gae_lambda", {0, 1}},
      {"ppo.entropy_coefficient", {0, kUnbounded}},
      {"ppo.entropy_coefficient_final", {0, kUnbounded}},
      {"ppo.max_gradient_norm", {0, kUnbounded, true}},
      {"ppo.kl_stop", {0, kUnbounded}},
      {"ppo.shared_heads_decay", {0, kUnbounded}},
      {"ppo.min_std", {0, 10}},
      {"ppo.std_decay", {0, 1}},
      {"ppo.log_std_rate", {0, kUnbounded}},
      {"ppo.reward_scale_decay", {0, 1, true}},
      {"ppo.success_weight", {0, 1e6}},
      {"ppo.earlier_batches", {0, 100}},
      {"sac.actor_learning_rate", {0, kUnbounded, true}},
      {"sac.critic_learning_rate", {0, kUnbounded, true}},
      {"sac.temperature_learning_rate", {0, kUnbounded}},
      {"sac.learning_rate_floor", {0, 1}},
      {"sac.adam_epsilon", {0, kUnbounded, true}},
      {"sac.batch", {1, 1 << 20}},
      {"sac.replay_ratio", {0, kUnbounded, true}},
      {"sac.replay_steps", {1, kUnbounded}},
      {"sac.random_episodes", {0, kUnbounded}},
      {"sac.discount", {0, 1}},
      {"sac.n_step", {1, kMaxSteps}},
      {"sac.target_rate", {0, 1, true}},
      {"sac.critic_hidden", {1, 4096}},
      {"sac.bins", {2, 4096}},
      {"sac.value_limit", {0, 80, true}},  // symexp of it is a finite float32
      {"sac.initial_temperature", {0, kUnbounded, true}},
      {"sac.target_std", {0, kUnbounded, true}},
      {"sac.final_target_std", {0, kUnbounded, true}},
      {"sac.target_std_decay", {0, 1}},
      {"sac.success_share", {0, 1}},
      {"sac.best_share", {0, 1}},
      {"sac.noise_spread", {1, 100}},
      {"sac.max_gradient_norm", {0, kUnbounded, true}},
      {"sac.shared_heads_decay", {0, kUnbounded}},
      {"collection.episodes_per_update", {1, 10000}},
      {"collection.overlap", {0, 1}},
      {"collection.check_share", {0, 1, true}},
      {"collection.check_tolerance", {0, kUnbounded}},
      {"runtime.domain", {0, 232}},
      {"runtime.learner_threads", {0, 1024}},
      {"runtime.checkpoint_every", {1, kUnbounded}},
      {"runtime.checkpoint_keep", {1, kUnbounded}},
      {"runtime.milestone_every", {0, kUnbounded}},
      {"runtime.audit_share", {0, 1}},
  };
  return ranges;
}

std::string RangeText(const Range& range) {
  if (range.high == kUnbounded) {
    return std::string("a finite number, ") + (range.low_open ? "above " : "at least ") +
           text::FormatNumber(range.low);
  }
  // Written out: shortest form would give 9007199254740991 as 9.007199254740991e+15.
  std::ostringstream high;
  high.precision(17);
  high << range.high;
  return std::string(range.low_open ? "above " : "from ") + text::FormatNumber(range.low) +
         (range.low_open ? ", at most " : " to ") + high.str();
}

bool Inside(double value, const Range& range) {
  return std::isfinite(value) && value <= range.high &&
         (range.low_open ? value > range.low : value >= range.low);
}

/// Gathers all complaints, so that one start names them all.
class Complaints {
 public:
  explicit Complaints(const ConfigOrigins& origins) : origins_(origins) {}

  void Add(const std::string& path, const std::string& what) {
    const auto origin = origins_.find(path);
    if (!text_.empty()) text_ += "\n";
    if (origin != origins_.end()) text_ += origin->second + ": ";
    text_ += path + " " + what;
  }

  void ThrowIfAny() const {
    if (!text_.empty()) throw ConfigError(text_);
  }

 private:
  const ConfigOrigins& origins_;
  std::string text_;
};

void CheckRanges(const RunConfig& config, Complaints& complaints) {
  VisitFields(config, [&](const std::string& path, const auto& owner, const auto& field) {
    const auto found = Ranges().find(path);
    if (found == Ranges().end()) return;
    // Whose absence has been complained of, and with it that of the horizon.
    if (path.starts_with("environment.") && !config.environment().has_spec()) return;
    std::istringstream values(FieldText(owner, field));
    for (std::string value; std::getline(values, value, ',');) {
      const auto number = text::ParseNumber<double>(value);
      if (number && Inside(*number, found->second)) continue;
      complaints.Add(path,
                     "is " + FieldText(owner, field) + ": must be " + RangeText(found->second));
      return;
    }
  });
}

void CheckSpec(const EnvironmentConfig& environment, Complaints& complaints) {
  const EnvironmentSpec& spec = environment.spec();
  const auto bounds_of = [&spec](const auto& bounds) {
    return bounds.size() == spec.action_size();
  };
  if (spec.action_size() < 1 || spec.action_size() > kMaxActionSize || spec.max_steps() < 1 ||
      spec.max_steps() > kMaxSteps) {
    return;  // CheckRanges says so
  }
  if (!bounds_of(spec.action_low()) || !bounds_of(spec.action_high())) {
    complaints.Add("environment.spec", "has no two bounds for each of the " +
                                           std::to_string(spec.action_size()) +
                                           " numbers of an action");
  }
  if (environment.horizon() > spec.max_steps() && environment.horizon() <= kMaxSteps) {
    complaints.Add("environment.horizon", "is " + std::to_string(environment.horizon()) +
                                              ": must be from 1 to " +
                                              std::to_string(spec.max_steps()) +
                                              ", the longest episode of " + spec.name());
  }
}

void CheckTasks(const RunConfig& config, Complaints& complaints) {
  const EnvironmentConfig& environment = config.environment();
  const int tasks = environment.spec().tasks_size();
  if (tasks > kMaxTasks) {
    complaints.Add("environment.task", "names " + std::to_string(tasks) +
                                           " tasks: must be at most " + std::to_string(kMaxTasks));
    return;
  }
  const std::string several = environment.task() + ", " + std::to_string(tasks) + " tasks";
  if (tasks > 1 && environment.placements() == PLACEMENTS_FIXED) {
    complaints.Add("environment.placements",
                   "is fixed, for " + several + ": must be random, mt1" +
                       (environment.spec().has_benchmark() ? " or benchmark" : ""));
  }
  if (environment.placements() == PLACEMENTS_BENCHMARK && !environment.spec().has_benchmark()) {
    complaints.Add("environment.placements", "is benchmark, and " + environment.task() +
                                                 " is none: must be random, mt1" +
                                                 (tasks > 1 ? "" : " or fixed"));
  }
  const int episodes = config.collection().episodes_per_update();
  if (tasks > 1 && episodes > 0 && episodes % tasks != 0) {
    complaints.Add("collection.episodes_per_update",
                   "is " + std::to_string(episodes) + ", for " + several +
                       ": must be a multiple, as " +
                       std::to_string((episodes + tasks - 1) / tasks * tasks) +
                       ", so that each has equally many");
  }
  const HeadsBy by = config.policy().heads_by();
  if (by != HEADS_BY_TIME && tasks <= 1) {
    complaints.Add("policy.heads_by", "is not time: that takes several tasks");
  } else if (by != HEADS_BY_TIME && config.policy().method() != MULTIHEAD) {
    complaints.Add("policy.heads_by", "is not time: that takes the method multihead");
  } else if (by == HEADS_BY_TASK && config.policy().heads() != 1) {
    complaints.Add("policy.heads", "is " + std::to_string(config.policy().heads()) +
                                       ": with heads by task each has 1 (task-time takes more)");
  } else if (std::int64_t{config.policy().heads()} * tasks > kMaxHeads) {
    complaints.Add("policy.heads", "is " + std::to_string(config.policy().heads()) +
                                       " for each of " + std::to_string(tasks) +
                                       " tasks: must be at most " + std::to_string(kMaxHeads) +
                                       " in all");
  }
}

void CheckEnvironment(const RunConfig& config, Complaints& complaints) {
  const auto& environment = config.environment();
  if (!environment.has_task()) {
    complaints.Add("environment.task",
                   "is not set: choose what `metronome-actor environment` lists");
  } else if (!HasSpec(config)) {
    complaints.Add("environment.spec", "is not that of " + environment.task() +
                                           ": nothing says how large its observations are");
  } else {
    CheckSpec(environment, complaints);
    CheckTasks(config, complaints);
  }
  const bool official = environment.placements() == PLACEMENTS_MT1 ||
                        environment.placements() == PLACEMENTS_BENCHMARK;
  if (official && config.seed() > kMostMt1Seed) {
    complaints.Add("seed", "is " + std::to_string(config.seed()) +
                               ": with official placements it must be from 0 to " +
                               std::to_string(kMostMt1Seed));
  }
}

void CheckPolicy(const RunConfig& config, Complaints& complaints) {
  const auto& policy = config.policy();
  const int horizon = config.environment().horizon();
  if (policy.hidden_size() > 8) {
    complaints.Add("policy.hidden",
                   "has " + std::to_string(policy.hidden_size()) + " layers: must be 1 to 8");
  }
  if (policy.heads() < 1) return;  // complained of already
  if (policy.method() != MULTIHEAD && policy.heads() != 1) {
    complaints.Add("policy.heads", "is " + std::to_string(policy.heads()) + ": the method " +
                                       (policy.method() == SINGLE ? "single" : "single-time") +
                                       " has exactly 1 (multihead takes more)");
  } else if (policy.heads() > horizon && horizon >= 1) {
    complaints.Add("policy.heads", "is " + std::to_string(policy.heads()) +
                                       ": must be at most environment.horizon, " +
                                       std::to_string(horizon) + " (each head needs a step)");
  }
}

void CheckBatch(const RunConfig& config, Complaints& complaints) {
  const std::int64_t episodes = config.collection().episodes_per_update();
  const std::int64_t horizon = config.environment().horizon();
  if (episodes < 1 || horizon < 1 || !config.has_ppo()) return;  // the former are complained of
  const std::int64_t steps =
      episodes * horizon * (1 + std::int64_t{config.ppo().earlier_batches()});
  if (config.ppo().minibatch() <= steps) return;
  complaints.Add("ppo.minibatch", "is " + std::to_string(config.ppo().minibatch()) +
                                      ": must be at most the steps of an update, " +
                                      std::to_string(steps) +
                                      " (episodes_per_update * horizon * (1 + earlier_batches))");
}

void CheckStds(const PpoConfig& ppo, Complaints& complaints) {
  if (!(ppo.std_decay() > 0) || ppo.min_std() > 0) return;
  complaints.Add("ppo.min_std",
                 "is 0: must be above 0 for ppo.std_decay, which lowers standard deviations to it");
}

// What a step is worth whose success lasts to the end of the episode.
double LargestSuccessReturn(const RunConfig& config) {
  double sum = 0;
  double weight = config.environment().success_reward();
  for (std::int32_t t = 0; t < config.environment().horizon(); ++t) {
    sum += weight;
    weight *= config.sac().discount();
  }
  return sum;
}

void CheckReplay(const RunConfig& config, Complaints& complaints) {
  const SacConfig& sac = config.sac();
  const std::int32_t horizon = config.environment().horizon();
  const std::int32_t least = std::max(sac.batch(), horizon);
  if (sac.replay_steps() < least) {
    complaints.Add("sac.replay_steps", "is " + std::to_string(sac.replay_steps()) +
                                           ": must be at least " + std::to_string(least) +
                                           ", a batch and an episode");
  }
  const double samples =
      sac.replay_ratio() * double(horizon) * double(config.collection().episodes_per_update());
  if (samples < double(sac.batch())) {
    complaints.Add("sac.replay_ratio",
                   "is " + text::FormatNumber(sac.replay_ratio()) + ": an update's " +
                       text::FormatNumber(samples) + " samples make no gradient step of " +
                       std::to_string(sac.batch()) +
                       " (sac.batch); raise it, or collection.episodes_per_update");
  }
  if (sac.n_step() > horizon) {
    complaints.Add("sac.n_step", "is " + std::to_string(sac.n_step()) +
                                     ": must be at most environment.horizon, " +
                                     std::to_string(horizon));
  }
}

// Only for settings whose every number is in range.
void CheckSac(const RunConfig& config, Complaints& complaints) {
  CheckReplay(config, complaints);
  if (config.sac().critic_hidden_size() > 8) {
    complaints.Add("sac.critic_hidden", "has " + std::to_string(config.sac().critic_hidden_size()) +
                                            " layers: must be 1 to 8");
  }
  if (config.environment().reward() != REWARD_SUCCESS) return;
  const double largest = LargestSuccessReturn(config);
  if (numbers::Log(1 + largest) <= config.sac().value_limit()) return;
  complaints.Add("sac.value_limit", "is " + text::FormatNumber(config.sac().value_limit()) +
                                        ": success alone is worth up to " +
                                        text::FormatNumber(largest) +
                                        " (environment.success_reward, sac.discount), whose "
                                        "ln(1 + x) is beyond it");
}

// Only for a shape whose every number is in range.
void CheckNetworkSize(const RunConfig& config, Complaints& complaints) {
  const std::size_t size = policy::ActorLayout(policy::ShapeOf(config)).size;
  if (size <= kMostPolicyParameters) return;
  complaints.Add("policy.hidden", "and policy.heads make a policy of " + std::to_string(size) +
                                      " parameters: must be at most " +
                                      std::to_string(kMostPolicyParameters) +
                                      " (what a snapshot holds on the wire)");
}

// Whether the learner knows it is for the learner to say.
void CheckAlgorithm(const RunConfig& config, Complaints& complaints) {
  if (!config.has_custom() || !config.custom().name().empty()) return;
  complaints.Add("custom.name", "is not set: name an algorithm that the learner knows");
}

/// The form alone: names are looked up when the run starts.
void CheckHosts(const std::string& path, const std::string& hosts, const std::string& allowed,
                Complaints& complaints) {
  try {
    text::ParseHostPorts(hosts);
  } catch (const std::invalid_argument& error) {
    complaints.Add(path, "is \"" + hosts + "\": must be " + allowed + "; " + error.what());
  }
}

// A lone word that nearly reads loopback or lan is a typo.
void CheckNetwork(const std::string& network, Complaints& complaints) {
  if (network == "loopback" || network == "lan") return;
  const std::string allowed = "loopback, lan, or the peers' addresses separated by commas";
  const bool lone_word = network.find_first_of(".,:0123456789") == std::string::npos;
  const auto near = text::NearMiss(network, {"loopback", "lan"});
  if (!lone_word || !near) return CheckHosts("runtime.network", network, allowed, complaints);
  complaints.Add("runtime.network",
                 "is \"" + network + "\"; did you mean \"" + *near + "\"? must be " + allowed);
}

void CheckDiscoveryServers(const std::string& servers, Complaints& complaints) {
  if (servers.empty()) return;
  CheckHosts("runtime.discovery_server", servers, "HOST[:PORT], separated by commas", complaints);
}

void CheckMetrics(const std::string& address, Complaints& complaints) {
  if (address.empty()) return;
  try {
    text::ParseListenAddress(address);
  } catch (const std::invalid_argument& error) {
    complaints.Add("runtime.metrics", "is \"" + address + "\": " + error.what());
  }
}

void CheckRuntime(const RunConfig& config, Complaints& complaints) {
  const std::string& transport = config.runtime().transport();
  if (transport != "udp" && transport != "shm" && transport != "tcp") {
    complaints.Add("runtime.transport",
                   "is an " + text::UnknownName("transport", transport, {"udp", "shm", "tcp"}));
  }
  CheckNetwork(config.runtime().network(), complaints);
  CheckDiscoveryServers(config.runtime().discovery_server(), complaints);
  CheckMetrics(config.runtime().metrics(), complaints);
}

}  // namespace

void Validate(const RunConfig& config, const ConfigOrigins& origins) {
  Complaints complaints(origins);
  CheckEnvironment(config, complaints);
  CheckRanges(config, complaints);
  CheckPolicy(config, complaints);
  CheckAlgorithm(config, complaints);
  CheckBatch(config, complaints);
  if (config.has_ppo()) CheckStds(config.ppo(), complaints);
  CheckRuntime(config, complaints);
  complaints.ThrowIfAny();
  if (config.has_sac()) CheckSac(config, complaints);
  CheckNetworkSize(config, complaints);
  complaints.ThrowIfAny();
}

}  // namespace metronome::config
