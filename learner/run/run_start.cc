#include "learner/run/run_start.h"

#include <spdlog/spdlog.h>

#include <algorithm>
#include <filesystem>
#include <utility>

#include "common/config/config.h"
#include "common/process/build_info.h"
#include "common/process/files.h"
#include "common/text/number_text.h"
#include "learner/record/episode_log.h"
#include "learner/record/run_folder.h"
#include "learner/run/initial_weights.h"

namespace metronome::run {
namespace {

void TellSource(const checkpoint::Checkpoint& source, const RunConfig& config) {
  spdlog::info("beginning with weights and observation statistics of {} ({}, update {}, {} steps)",
               config.policy().initial_weights(), source.config.environment().task(),
               source.state.version, source.state.steps);
  const TrainingDifferences differences = DifferencesFrom(source, config);
  for (const std::string& line : differences.intended) spdlog::info("the weights' {}", line);
  for (const std::string& line : differences.doubtful) {
    spdlog::warn("the weights' {}: each head has learnt another part of the episode", line);
  }
}

RunStart FreshStart(const RunRequest& request, const algorithm::AlgorithmFactory& factory) {
  const RunConfig& config = request.config;
  RunStart start;
  start.checkpoint.config = config;
  start.checkpoint.engine = process::EngineName();
  if (config.policy().initial_weights().empty()) {
    start.checkpoint.state = factory.InitialState(config, nullptr);
    return start;
  }
  const checkpoint::Checkpoint source = LoadInitialWeights(config, request.specs);
  try {
    start.checkpoint.state = factory.InitialState(config, &source.state);
  } catch (const algorithm::UnusableState& error) {
    throw CannotStart("--from " + config.policy().initial_weights() + ": " + error.what());
  }
  start.checkpoint.initial_weights_sha256 = source.state.weights.sha256;
  TellSource(source, config);
  return start;
}

/// A run's first row comes after its first checkpoint.
void RequireNoProgress(const RunRequest& request, const std::string& checkpoints) {
  const std::string path = request.folder + "/progress.csv";
  if (!std::filesystem::exists(path)) return;
  const std::string content = process::ReadFile(path);
  const auto lines = std::count(content.begin(), content.end(), '\n');
  if (lines <= 1) return;
  throw CannotStart("run " + request.run + " has lost its checkpoints: " + path + " tells of " +
                    text::Counted(static_cast<std::uint64_t>(lines - 1), "update") +
                    ", and there is none in " + checkpoints +
                    "; put a copy there, or begin anew under another --run");
}

void RequireSameRun(const checkpoint::FoundCheckpoint& found, const RunRequest& request) {
  const checkpoint::Checkpoint& checkpoint = found.checkpoint;
  if (checkpoint.engine != process::EngineName()) {
    throw CannotStart(found.path + " was trained on " + checkpoint.engine +
                      ", this learner is built for " + process::EngineName() +
                      ": resume with a build for " + checkpoint.engine);
  }
  checkpoint::RequireState(checkpoint, found.path);
  checkpoint::RequireShape(checkpoint, request.config, found.path);
  // The total may differ: the command line has compared it with the run's own file.
  const auto differences = config::CompareForResume(checkpoint.config, request.config, true);
  if (differences.empty()) return;
  throw CannotStart(found.path + " belongs to another configuration than " +
                    record::ConfigPathOf(request.folder) +
                    " (remove that one to go on with the checkpoint's): " + differences.front());
}

void Tell(const checkpoint::FoundCheckpoint& found) {
  if (found.passed_over.empty()) {
    spdlog::info("going on from {}", found.path);
    return;
  }
  for (const auto& passed : found.passed_over) spdlog::warn("{}", passed.why);
  spdlog::warn(
      "GOING ON FROM {} (update {}), the newest checkpoint that is whole: updates since then are "
      "made again, to the same bits; damaged files are kept as *.damaged",
      found.path, found.checkpoint.state.version);
}

std::vector<Episode> ReplayOf(const checkpoint::FoundCheckpoint& found, const std::string& folder) {
  try {
    return record::EpisodeLog::Read(folder, found.checkpoint.replay);
  } catch (const record::ReplayDamaged& error) {
    throw CannotStart(std::string(error.what()) + ": " + found.path +
                      " cannot be gone on from without its replay; put a whole copy there, or "
                      "begin anew under another --run");
  }
}

}  // namespace

RunStart StartOf(const RunRequest& request, const algorithm::AlgorithmFactory& factory) {
  if (!request.resume) return FreshStart(request, factory);
  const std::string folder = request.folder + "/checkpoints";
  auto found = checkpoint::FindNewestCheckpoint(folder, request.specs);
  if (!found) {
    RequireNoProgress(request, folder);
    // Killed before its first checkpoint, so before its first assignment: nothing is lost.
    spdlog::info("run {} has no checkpoint yet: it begins at version 0", request.run);
    return FreshStart(request, factory);
  }
  RequireSameRun(*found, request);
  std::vector<Episode> replay = ReplayOf(*found, request.folder);
  Tell(*found);
  checkpoint::CheckpointStore(folder, request.config.runtime().checkpoint_keep()).GoOnFrom(*found);
  RunStart start{std::move(found->checkpoint), true, found->path, std::move(replay)};
  start.checkpoint.config = request.config;
  return start;
}

std::unique_ptr<algorithm::Algorithm> AlgorithmOf(RunStart& start,
                                                  const algorithm::AlgorithmFactory& factory,
                                                  algorithm::AlgorithmResources resources) {
  resources.replay = std::move(start.replay);
  try {
    return factory.Make(start.checkpoint.config, start.checkpoint.state, resources);
  } catch (const algorithm::UnusableState& error) {
    throw CannotStart(start.path + ": " + error.what());
  }
}

}  // namespace metronome::run
