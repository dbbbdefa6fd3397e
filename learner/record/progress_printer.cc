#include "learner/record/progress_printer.h"

#include <spdlog/fmt/fmt.h>

#include <nlohmann/json.hpp>
#include <utility>

#include "common/text/number_text.h"
#include "learner/record/rates.h"

namespace metronome::record {
namespace {

using Json = nlohmann::ordered_json;

// Paths may hold bytes that are not UTF-8.
std::string TextOf(const Json& record) {
  return record.dump(-1, ' ', false, Json::error_handler_t::replace);
}

std::string ClockText(double seconds) {
  const auto whole = static_cast<std::uint64_t>(seconds);
  return fmt::format("{}:{:02}:{:02}", whole / 3600, whole / 60 % 60, whole % 60);
}

}  // namespace

ProgressPrinter::ProgressPrinter(ProgressStyle style, RunFacts facts,
                                 std::function<void(std::string)> say)
    : style_(style),
      facts_(std::move(facts)),
      updates_total_(facts_.length.updates),
      say_(std::move(say)) {}

void ProgressPrinter::Started(std::uint64_t version, std::uint64_t steps) {
  updates_total_ = facts_.length.UpdatesAt(version, steps);
  if (style_ == ProgressStyle::kLines) {
    Say(fmt::format("run {} (incarnation {}): update {} of {}, results in {}", facts_.run,
                    facts_.incarnation, version, updates_total_, facts_.path));
  } else if (style_ == ProgressStyle::kJson) {
    Say(TextOf({{"event", "started"},
                {"run", facts_.run},
                {"incarnation", facts_.incarnation},
                {"path", facts_.path},
                {"update", version},
                {"updates_total", updates_total_},
                {"steps", steps},
                {"total_steps", facts_.length.total_steps},
                {"episodes_per_update", facts_.episodes_per_update},
                {"domain", facts_.domain},
                {"transport", facts_.transport},
                {"network", facts_.network},
                {"discovery_server", facts_.discovery_server},
                {"placements", facts_.placements},
                {"security", facts_.security}}));
  }
}

void ProgressPrinter::Updated(const algorithm::UpdateReport& report, const WallReport& wall) {
  updates_total_ = facts_.length.UpdatesAt(report.version, report.steps);
  const double fps = StepsPerSecond(report.steps, wall.seconds);
  const double eta = SecondsLeft(report.steps, facts_.length.total_steps, fps);
  if (style_ == ProgressStyle::kLines) {
    Say(fmt::format(
        "update {:>4}/{}  {:>8}/{} steps  return {:8.1f}  success {:.2f}  "
        "{:6.0f} steps/s  {}  {} left",
        report.version, updates_total_, report.steps, facts_.length.total_steps, report.mean_return,
        report.success, fps, text::Counted(wall.actors, "actor"), ClockText(eta)));
  } else if (style_ == ProgressStyle::kJson) {
    Say(TextOf({{"update", report.version},
                {"updates_total", updates_total_},
                {"steps", report.steps},
                {"total_steps", facts_.length.total_steps},
                {"return", report.mean_return},
                {"success", report.success},
                {"success_end", report.success_end},
                {"fps", fps},
                {"seconds", wall.seconds},
                {"eta_seconds", eta},
                {"actors", wall.actors},
                {"envs", wall.envs},
                {"idle_share", wall.idle_share}}));
  }
}

void ProgressPrinter::Finished(const std::string& accounting, const std::string& checkpoint,
                               const std::string& weights_sha256) {
  if (style_ == ProgressStyle::kLines) {
    Say("finished: " + accounting);
    Say("checkpoint " + checkpoint + ", weights " + weights_sha256);
  } else if (style_ == ProgressStyle::kJson) {
    Say(TextOf({{"event", "finished"},
                {"run", facts_.run},
                {"message", accounting},
                {"accounting", accounting},
                {"checkpoint", checkpoint},
                {"weights_sha256", weights_sha256}}));
  }
}

void ProgressPrinter::Interrupted(std::uint64_t version, const std::string& checkpoint) {
  const std::string message = fmt::format("stopped after update {} of {}", version, updates_total_);
  if (style_ == ProgressStyle::kLines) {
    Say(message + "; go on with --resume; checkpoint " + checkpoint);
  } else if (style_ == ProgressStyle::kJson) {
    Say(TextOf({{"event", "interrupted"},
                {"run", facts_.run},
                {"message", message},
                {"update", version},
                {"checkpoint", checkpoint}}));
  }
}

}  // namespace metronome::record
