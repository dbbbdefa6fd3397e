#include "learner/watch/status_text.h"

#include <spdlog/fmt/fmt.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "common/text/number_text.h"
#include "learner/watch/old_names.h"

namespace metronome::watch {
namespace {

using Json = nlohmann::ordered_json;

std::string TrustText(const ActorReport& actor) {
  if (actor.unanswering) return "does not answer";
  return actor.on_probation ? "on probation" : "trusted";
}

template <std::size_t N>
void AddOldNames(const OldName (&names)[N], Json& json) {
  for (const OldName& row : names) {
    if (row.old_name != nullptr) json[row.old_name] = json[std::string(row.name)];
  }
}

Json JsonOf(const TaskStatus& task) {
  Json json;
  VisitTaskNumbers(
      [&](const StatusNumber& number, auto member) { json[number.name] = task.*member; });
  return json;
}

std::string TaskTable(const std::vector<TaskStatus>& tasks) {
  std::size_t width = 4;
  for (const TaskStatus& task : tasks) width = std::max(width, task.name.size());
  std::string text =
      fmt::format("{:<{}}  {:>8}  {:>7}  {:>6}\n", "task", width, "return", "success", "at end");
  for (const TaskStatus& task : tasks) {
    text += fmt::format("{:<{}}  {:>8.1f}  {:>7.2f}  {:>6.2f}\n", task.name, width,
                        task.mean_return, task.success, task.success_end);
  }
  return text;
}

Json JsonOf(const ActorReport& actor) {
  Json json = {{"name", actor.name}};
  VisitActorNumbers(
      [&](const StatusNumber& number, auto member) { json[number.name] = actor.*member; });
  AddOldNames(kOldActorNames, json);
  return json;
}

}  // namespace

std::string StatusTable(const LearnerStatus& status) {
  std::string text = fmt::format(
      "run {} (incarnation {}): {}, task {}, {}, learner {}:{}\n"
      "update {}/{}  {}/{} steps  return {:.1f}  success {:.2f} (at the end {:.2f})  {:.0f} "
      "steps/s  "
      "{:.0f} s, {:.0f} s left\n"
      "batch {}/{} episodes  collected in {:.1f} s, learnt in {:.1f} s, envs idle {:.0f} %  "
      "checkpoint {}\n"
      "episodes: accepted {}, reassigned {}, duplicates {}, rejected {}, stale {}; bytes: sent {}, "
      "received {}\n",
      status.run_name, status.incarnation, StateText(status.state), status.task, status.engine,
      status.host, status.pid, status.version, status.updates_total, status.steps,
      status.total_steps, status.mean_return, status.success, status.success_end, status.fps,
      status.seconds, status.eta_seconds, status.batch_episodes, status.episodes_per_update,
      status.collect_seconds, status.update_seconds, 100 * status.idle_share,
      status.checkpoint_version, status.accepted, status.reassigned, status.duplicates,
      status.rejected, status.stale, status.bytes_sent, status.bytes_received);
  text += text::Counted(status.actors_total, "actor") + " with " +
          text::Counted(status.envs_total, "env") + "\n";
  if (status.age_seconds >= kOldStatusSeconds) {
    text.insert(
        0,
        fmt::format("OLD: the learner has said nothing for {:.0f} s; this is how it stood then\n",
                    status.age_seconds));
  }
  if (!status.tasks.empty()) text += TaskTable(status.tasks);
  if (status.actors.empty()) return text;
  std::size_t width = 5;
  for (const ActorReport& actor : status.actors) width = std::max(width, actor.name.size());
  text += fmt::format("{:<{}}  {:>5}  {:>8}  {:>8}  {:>8}  {:>8}  {:>6}  {:>7}  {}\n", "actor",
                      width, "envs", "steps/s", "accepted", "rejected", "assigned", "lag s",
                      "heard s", "trust");
  for (const ActorReport& actor : status.actors) {
    text += fmt::format("{:<{}}  {:>5}  {:>8.0f}  {:>8}  {:>8}  {:>8}  {:>6.1f}  {:>7.1f}  {}\n",
                        actor.name, width, actor.envs, actor.steps_per_second, actor.accepted,
                        actor.rejected, actor.assignments, actor.oldest_assignment_seconds,
                        actor.silent_seconds, TrustText(actor));
  }
  if (status.actors_total > status.actors.size()) {
    text += fmt::format("and {} more\n", status.actors_total - status.actors.size());
  }
  return text;
}

std::string StatusJson(const LearnerStatus& status) {
  Json json;
  VisitLearnerIdentity([&](const char* name, auto member) { json[name] = status.*member; });
  json["state"] = StateText(status.state);
  json["age_seconds"] = status.age_seconds;
  VisitRunNumbers(
      [&](const StatusNumber& number, auto member) { json[number.name] = status.*member; });
  if (!status.tasks.empty()) json["tasks"] = Json::object();
  for (const TaskStatus& task : status.tasks) json["tasks"][task.name] = JsonOf(task);
  json["actors"] = Json::array();
  for (const ActorReport& actor : status.actors) json["actors"].push_back(JsonOf(actor));
  AddOldNames(kOldRunNames, json);
  return json.dump(-1, ' ', false, Json::error_handler_t::replace);
}

}  // namespace metronome::watch
