#include "actor/client/actor_client.h"

#include <spdlog/spdlog.h>

#include <algorithm>
#include <utility>

#include "common/config/config.h"
#include "common/policy/snapshot.h"
#include "common/text/number_text.h"

namespace metronome::client {
namespace {

constexpr std::chrono::milliseconds kCloseTimeout{2000};
// A run has one, and one more while it changes; outsiders may say that they are some.
constexpr std::size_t kMostLearners = 16;

double Seconds(Clock::duration duration) { return std::chrono::duration<double>(duration).count(); }

/// The newest incarnation of those that serve or have served; of equals the lower id.
const RunDescription* Best(const std::map<std::uint64_t, RunDescription>& learners) {
  const RunDescription* best = nullptr;
  for (const auto& [id, learner] : learners) {
    if (!learner.serving && !learner.finished) continue;
    if (best == nullptr || learner.incarnation > best->incarnation) best = &learner;
  }
  return best;
}

/// The oldest incarnation but the obeyed one goes when there are too many: it is never the best.
void ForgetOldest(const std::optional<RunDescription>& obeyed,
                  std::map<std::uint64_t, RunDescription>* learners) {
  if (learners->size() <= kMostLearners) return;
  const auto age = [&obeyed](const auto& entry) {
    const bool is_obeyed = obeyed && entry.first == obeyed->learner_id;
    return std::pair(is_obeyed, entry.second.incarnation);
  };
  learners->erase(
      std::min_element(learners->begin(), learners->end(),
                       [&age](const auto& a, const auto& b) { return age(a) < age(b); }));
}

bool SameStart(const RunDescription& a, const RunDescription& b) {
  return a.learner_id == b.learner_id && a.incarnation == b.incarnation;
}

/// @return the complaint, or std::nullopt.
std::optional<std::string> ParseRunConfig(const std::string& bytes, RunConfig* config) {
  if (!config->ParseFromString(bytes)) return "it does not parse";
  try {
    config::Validate(*config);
  } catch (const config::ConfigError& error) {
    return error.what();
  }
  return std::nullopt;
}

}  // namespace

struct ActorClient::EndOfRun {
  ActorClient* client;
  ~EndOfRun() {
    if (client->workers_) client->workers_->Cancel();
    client->bus_->Close(kCloseTimeout);  // before joining: a worker may be blocked in Send
    client->workers_.reset();
  }
};

ActorClient::ActorClient(ActorBus* bus, SetUpRun set_up_run, ActorClientOptions options)
    : bus_(bus), set_up_run_(std::move(set_up_run)), options_(std::move(options)) {}

void ActorClient::Stop() {
  stopped_ = true;
  bus_->Wake();
}

ActorEnd ActorClient::Run() {
  const EndOfRun end_of_run{this};
  StartWaiting("no learner for run '" + options_.run_name + "' is heard yet");
  hint_ = options_.why_no_learner;
  while (!stopped_) {
    std::optional<ActorEnd> end;
    if (auto event = bus_->Wait(NextTick())) end = Handle(*std::move(event));
    if (workers_ && workers_->failure()) std::rethrow_exception(workers_->failure());
    if (!end) end = Tick();
    if (end) return *end;
  }
  return ActorEnd::kStopped;
}

std::optional<ActorEnd> ActorClient::Handle(ActorEvent event) {
  if (auto* description = std::get_if<RunDescription>(&event)) {
    return HandleDescription(std::move(*description));
  }
  if (auto* assignment = std::get_if<EpisodeAssignment>(&event))
    return HandleAssignment(*assignment);
  if (auto* lost = std::get_if<LearnerLost>(&event)) return HandleLost(lost->learner_id);
  if (auto* snapshot = std::get_if<PolicySnapshot>(&event)) {
    book_.Add(std::move(*snapshot));
    QueueReady();
  }
  if (auto* bad = std::get_if<BadSample>(&event)) {
    spdlog::warn("dropped a sample of {}: {}", bad->topic, bad->reason);
  }
  return std::nullopt;
}

std::optional<ActorEnd> ActorClient::HandleDescription(RunDescription description) {
  if (description.protocol_version != kProtocolVersion) {
    spdlog::error(
        "a learner of run '{}' speaks protocol version {}, this actor {}: build both from "
        "the same sources",
        options_.run_name, description.protocol_version, kProtocolVersion);
    if (obeyed_ && !waiting_since_) return std::nullopt;  // a stranger; the run goes on
    return ActorEnd::kRefused;
  }
  if (description.run_name != options_.run_name) {
    spdlog::warn("dropped the description of run '{}': this actor serves '{}'",
                 description.run_name, options_.run_name);
    return std::nullopt;
  }
  hint_.clear();
  const std::uint64_t id = description.learner_id;
  learners_[id] = std::move(description);
  ForgetOldest(obeyed_, &learners_);
  return Reconsider();
}

std::optional<ActorEnd> ActorClient::HandleLost(std::uint64_t learner_id) {
  learners_.erase(learner_id);
  if (obeyed_ && obeyed_->learner_id == learner_id && !waiting_since_) {
    StartWaiting("the learner of run '" + options_.run_name + "' is gone: waiting for its return");
    spdlog::warn("{}", waiting_for_);
  }
  return Reconsider();
}

std::optional<ActorEnd> ActorClient::Reconsider() {
  const RunDescription* best = Best(learners_);
  if (best == nullptr) return std::nullopt;
  if (best->finished) return Finish();
  if (!obeyed_ || !SameStart(*obeyed_, *best)) return Adopt(RunDescription(*best));
  if (waiting_since_) spdlog::info("the learner is back");
  waiting_since_.reset();
  return std::nullopt;
}

std::optional<ActorEnd> ActorClient::Adopt(const RunDescription& description) {
  if (description.engine != options_.engine) {
    spdlog::error(
        "run '{}' is on engine {}, this actor was built on {}: start an actor of that "
        "engine",
        options_.run_name, description.engine, options_.engine);
    return ActorEnd::kRefused;
  }
  RunConfig config;
  if (const auto complaint = ParseRunConfig(description.config, &config)) {
    spdlog::error("dropped a description of run '{}' whose configuration is wrong: {}",
                  options_.run_name, *complaint);
    learners_.erase(description.learner_id);
    return std::nullopt;
  }
  LeaveRun();
  RunSetup setup = SetUp(config);
  config_ = std::move(config);
  canonical_digest_ = std::move(setup.canonical_digest);
  obeyed_ = description;
  waiting_since_.reset();
  steps_at_last_status_ = 0;
  idle_since_ = Clock::now();
  next_idle_notice_ = idle_since_ + options_.idle_notice_every;
  workers_ = std::make_unique<WorkerPool>(
      std::move(setup.players),
      [this, incarnation = description.incarnation](Episode episode) {
        Deliver(incarnation, std::move(episode));
      },
      [this] { bus_->Wake(); });
  spdlog::info("joined run '{}' (task {}, engine {}, incarnation {}) with {}", options_.run_name,
               config_.environment().task(), options_.engine, description.incarnation,
               text::Counted(static_cast<std::uint64_t>(options_.envs), "env"));
  book_.Obey(description.incarnation);
  SendStatus();
  QueueReady();
  return std::nullopt;
}

RunSetup ActorClient::SetUp(const RunConfig& config) const {
  try {
    return set_up_run_(config, options_.envs);
  } catch (const std::exception& error) {
    throw SetUpFailed(error.what());
  }
}

std::optional<ActorEnd> ActorClient::Finish() {
  if (!options_.stay) {
    spdlog::info("run '{}' is finished: {} played here", options_.run_name,
                 text::Counted(episodes_done_, "episode"));
    return ActorEnd::kFinished;
  }
  if (!obeyed_ && waiting_since_) return std::nullopt;
  LeaveRun();
  book_.ObeyNobody();
  StartWaiting("run '" + options_.run_name + "' is finished: staying for the next of that name");
  spdlog::info("{}", waiting_for_);
  return std::nullopt;
}

void ActorClient::LeaveRun() {
  workers_.reset();
  obeyed_.reset();
}

std::optional<ActorEnd> ActorClient::HandleAssignment(const EpisodeAssignment& assignment) {
  if (assignment.kind == EpisodeAssignment::Kind::kRefuse) {
    if (obeyed_ && assignment.incarnation < obeyed_->incarnation) return std::nullopt;
    spdlog::error("the learner of run '{}' refused this actor: {}", options_.run_name,
                  assignment.reason);
    return ActorEnd::kRefused;
  }
  if (!book_.Add(assignment)) {
    spdlog::warn("dropped an assignment of {}: {} wait already",
                 text::Counted(assignment.numbers.size(), "episode"), book_.held());
  }
  QueueReady();
  return std::nullopt;
}

void ActorClient::QueueReady() {
  if (!workers_) return;
  std::vector<EpisodeTask> tasks = book_.TakeReady();
  std::erase_if(tasks, [this](const EpisodeTask& task) {
    const auto defect = policy::SnapshotDefect(*task.snapshot, config_);
    if (!defect) return false;
    spdlog::warn("dropped the assignment of episode {}: snapshot {} cannot be acted with: {}",
                 task.number, task.snapshot->version, *defect);
    return true;
  });
  workers_->Add(std::move(tasks));
}

void ActorClient::Deliver(std::uint64_t incarnation, Episode episode) {
  EpisodeMessage message;
  message.incarnation = incarnation;
  message.actor_id = options_.actor_id;
  message.episode = std::move(episode);
  if (bus_->Send(std::move(message)) == ActorBus::SendResult::kSent) ++episodes_done_;
  // Without a learner the episode is dropped: it will be reassigned.
}

void ActorClient::StartWaiting(const std::string& cause) {
  waiting_since_ = Clock::now();
  waiting_for_ = cause;
  next_notice_ = *waiting_since_ + options_.notice_every;
}

std::optional<ActorEnd> ActorClient::Tick() {
  const Clock::time_point now = Clock::now();
  if (obeyed_ && now >= next_status_) SendStatus();
  return waiting_since_ ? TickWithoutLearner(now) : std::nullopt;
}

std::optional<ActorEnd> ActorClient::TickWithoutLearner(Clock::time_point now) {
  const double waited = Seconds(now - *waiting_since_);
  if (options_.patience && now - *waiting_since_ >= *options_.patience) {
    spdlog::error("{}: giving up after {:.0f} s{}", waiting_for_, waited,
                  hint_.empty() ? "" : ": " + hint_);
    return ActorEnd::kNoLearner;
  }
  if (now < next_notice_) return std::nullopt;
  next_notice_ = now + options_.notice_every;
  if (!hint_.empty()) {
    spdlog::warn("{} ({:.0f} s): {}", waiting_for_, waited, std::exchange(hint_, ""));
  } else if (options_.patience) {
    spdlog::info("{} ({:.0f} s of {:.0f} s)", waiting_for_, waited, Seconds(*options_.patience));
  } else {
    spdlog::info("{} ({:.0f} s)", waiting_for_, waited);
  }
  return std::nullopt;
}

void ActorClient::SendStatus() {
  const Clock::time_point now = Clock::now();
  const std::uint64_t steps = workers_->steps();
  ActorStatus status;
  status.actor_id = options_.actor_id;
  status.incarnation = obeyed_->incarnation;
  status.host = options_.host;
  status.pid = options_.pid;
  status.engine = options_.engine;
  status.build = options_.build;
  status.canonical_digest = canonical_digest_;
  status.envs = static_cast<std::uint32_t>(options_.envs);
  status.episodes_done = episodes_done_;
  const double passed = Seconds(now - last_status_);
  if (steps > 0) {
    status.steps_per_second = static_cast<double>(steps - steps_at_last_status_) / passed;
  }
  bus_->Send(status);
  NoticeIdleness(steps, now);
  last_status_ = now;
  steps_at_last_status_ = steps;
  next_status_ = now + options_.status_every;
}

// An actor that does nothing says what it waits for.
void ActorClient::NoticeIdleness(std::uint64_t steps, Clock::time_point now) {
  if (steps != steps_at_last_status_) {
    idle_since_ = now;
    next_idle_notice_ = now + options_.idle_notice_every;
  }
  if (now < next_idle_notice_ || waiting_since_) return;
  next_idle_notice_ = now + options_.idle_notice_every;
  if (book_.held() > 0) {
    spdlog::info("idle for {:.0f} s: no policy snapshot yet for {}", Seconds(now - idle_since_),
                 text::Counted(book_.held(), "assigned episode"));
  } else {
    spdlog::info(
        "idle for {:.0f} s: the learner of run '{}' is there and has assigned nothing (it updates, "
        "has fewer episodes than envs, or prefers steadier actors)",
        Seconds(now - idle_since_), options_.run_name);
  }
}

Clock::time_point ActorClient::NextTick() const {
  Clock::time_point next = Clock::time_point::max();
  if (obeyed_) next = next_status_;
  if (!waiting_since_) return next;
  next = std::min(next, next_notice_);
  return options_.patience ? std::min(next, *waiting_since_ + *options_.patience) : next;
}

}  // namespace metronome::client
