#include "learner/watch/status_text.h"

#include <spdlog/fmt/fmt.h>

#include <algorithm>
#include <nlohmann/json.hpp>

namespace metronome {
namespace {

using Json = nlohmann::ordered_json;

std::string TrustText(const ActorReport& actor) {
  if (actor.unanswering) return "does not answer";
  return actor.on_probation ? "on probation" : "trusted";
}

Json JsonOf(const ActorReport& actor) {
  return {{"name", actor.name},
          {"slots", actor.slots},
          {"episodes_done", actor.episodes_done},
          {"steps_per_second", actor.steps_per_second},
          {"accepted", actor.accepted},
          {"rejected", actor.rejected},
          {"orders", actor.orders},
          {"oldest_order_seconds", actor.oldest_order_seconds},
          {"silent_seconds", actor.silent_seconds},
          {"on_probation", actor.on_probation},
          {"unanswering", actor.unanswering}};
}

}  // namespace

std::string StatusTable(const LearnerStatus& status) {
  std::string text = fmt::format(
      "run {} (start {}): {}, task {}, {}, learner {}:{}\n"
      "update {}/{}  {}/{} steps  return {:.1f}  success {:.2f} (at the end {:.2f})  {:.0f} "
      "steps/s  "
      "{:.0f} s, {:.0f} s left\n"
      "batch {}/{} episodes  collected in {:.1f} s, learnt in {:.1f} s, slots idle {:.0f} %  "
      "checkpoint {}\n"
      "episodes: accepted {}, re-ordered {}, duplicates {}, rejected {}, stale {}; bytes: sent {}, "
      "received {}\n",
      status.run_name, status.incarnation, StateText(status.state), status.task, status.engine,
      status.host, status.pid, status.version, status.updates_total, status.steps,
      status.total_steps, status.mean_return, status.success, status.success_end, status.fps,
      status.seconds, status.eta_seconds, status.batch_episodes, status.episodes_per_update,
      status.collect_seconds, status.update_seconds, 100 * status.idle_share,
      status.checkpoint_version, status.accepted, status.reordered, status.duplicates,
      status.rejected, status.stale, status.bytes_sent, status.bytes_received);
  text += fmt::format("{} actors with {} slots\n", status.actors_total, status.slots_total);
  if (status.age_seconds >= kOldStatusSeconds) {
    text.insert(
        0,
        fmt::format("OLD: the learner has said nothing for {:.0f} s; this is how it stood then\n",
                    status.age_seconds));
  }
  if (status.actors.empty()) return text;
  std::size_t width = 5;
  for (const ActorReport& actor : status.actors) width = std::max(width, actor.name.size());
  text += fmt::format("{:<{}}  {:>5}  {:>8}  {:>8}  {:>8}  {:>6}  {:>6}  {:>7}  {}\n", "actor",
                      width, "slots", "steps/s", "accepted", "rejected", "orders", "lag s",
                      "heard s", "trust");
  for (const ActorReport& actor : status.actors) {
    text += fmt::format("{:<{}}  {:>5}  {:>8.0f}  {:>8}  {:>8}  {:>6}  {:>6.1f}  {:>7.1f}  {}\n",
                        actor.name, width, actor.slots, actor.steps_per_second, actor.accepted,
                        actor.rejected, actor.orders, actor.oldest_order_seconds,
                        actor.silent_seconds, TrustText(actor));
  }
  if (status.actors_total > status.actors.size()) {
    text += fmt::format("and {} more\n", status.actors_total - status.actors.size());
  }
  return text;
}

std::string StatusJson(const LearnerStatus& status) {
  Json json = {{"run_name", status.run_name},
               {"incarnation", status.incarnation},
               {"learner_id", status.learner_id},
               {"task", status.task},
               {"engine", status.engine},
               {"host", status.host},
               {"pid", status.pid},
               {"state", StateText(status.state)},
               {"age_seconds", status.age_seconds},
               {"version", status.version},
               {"updates_total", status.updates_total},
               {"steps", status.steps},
               {"total_steps", status.total_steps},
               {"mean_return", status.mean_return},
               {"success", status.success},
               {"success_end", status.success_end},
               {"fps", status.fps},
               {"seconds", status.seconds},
               {"eta_seconds", status.eta_seconds},
               {"collect_seconds", status.collect_seconds},
               {"update_seconds", status.update_seconds},
               {"idle_share", status.idle_share},
               {"batch_episodes", status.batch_episodes},
               {"episodes_per_update", status.episodes_per_update},
               {"accepted", status.accepted},
               {"reordered", status.reordered},
               {"duplicates", status.duplicates},
               {"rejected", status.rejected},
               {"stale", status.stale},
               {"bytes_sent", status.bytes_sent},
               {"bytes_received", status.bytes_received},
               {"checkpoint_version", status.checkpoint_version},
               {"actors_total", status.actors_total},
               {"slots_total", status.slots_total}};
  json["actors"] = Json::array();
  for (const ActorReport& actor : status.actors) json["actors"].push_back(JsonOf(actor));
  return json.dump(-1, ' ', false, Json::error_handler_t::replace);
}

}  // namespace metronome
