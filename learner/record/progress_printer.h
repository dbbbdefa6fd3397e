#pragma once

#include <cstdint>
#include <functional>
#include <string>

#include "learner/algorithm/update_report.h"
#include "learner/record/metrics.h"
#include "learner/record/run_length.h"

namespace metronome::record {

enum class ProgressStyle { kLines, kJson, kNone };

/// Facts of a run that do not change while it is served.
struct RunFacts {
  std::string run;
  std::string path;  // of its folder
  std::uint64_t incarnation = 0;
  RunLength length;
  std::uint64_t episodes_per_update = 0;
  std::string network;  // how actors join: domain, transport, network, Discovery Servers
  std::string transport;
  std::string discovery_server;
  std::uint32_t domain = 0;
  std::string placements;  // where objects start: "fixed", say
  std::string security;    // folder of the learner's identity; empty: none
};

/// The progress of `run`: lines for people, one JSON object a line for programs, or nothing. JSON
/// keys are stable; see learner/README.md. Not thread-safe.
class ProgressPrinter {
 public:
  /// @param say  called with each line, its end included; must not block.
  ProgressPrinter(ProgressStyle style, RunFacts facts, std::function<void(std::string line)> say);

  /// The run is accepted; `version` updates were made before.
  void Started(std::uint64_t version, std::uint64_t steps);
  void Updated(const algorithm::UpdateReport& report, const WallReport& wall);
  void Finished(const std::string& accounting, const std::string& checkpoint,
                const std::string& weights_sha256);
  void Interrupted(std::uint64_t version, const std::string& checkpoint);

 private:
  void Say(const std::string& line) { say_(line + "\n"); }

  ProgressStyle style_;
  RunFacts facts_;
  std::uint64_t updates_total_;  // as far as it is known
  std::function<void(std::string)> say_;
};

}  // namespace metronome::record
