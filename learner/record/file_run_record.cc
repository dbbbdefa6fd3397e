#include "learner/record/file_run_record.h"

#include <cerrno>
#include <system_error>
#include <utility>

#include "common/config/config.h"
#include "common/process/files.h"
#include "learner/record/run_folder.h"

namespace metronome::record {

FileRunRecord::FileRunRecord(std::string folder, checkpoint::Checkpoint first,
                             std::vector<algorithm::Metric> algorithm, ProgressPrinter printer)
    : folder_(std::move(folder)), checkpoint_(std::move(first)), printer_(std::move(printer)) {
  blank_.tasks = algorithm::TasksOf(checkpoint_.config);
  blank_.metrics = std::move(algorithm);
  if (checkpoint_.logs.progress_bytes > 0) ProgressLog::RequireHeader(ProgressPath(), blank_);
}

std::string FileRunRecord::ProgressPath() const { return folder_ + "/progress.csv"; }

void FileRunRecord::Begin() {
  process::WriteFileAtomically(ConfigPathOf(folder_), config::PrintConfig(checkpoint_.config));
  store_.emplace(folder_ + "/checkpoints", checkpoint_.config.runtime().checkpoint_keep(),
                 checkpoint_.config.runtime().milestone_every());
  progress_.emplace(ProgressPath(), blank_, checkpoint_.logs.progress_bytes);
  events_.emplace(folder_ + "/" + TensorBoardLog::kFileName, checkpoint_.logs.events_bytes);
  const RunConfig& config = checkpoint_.config;
  if (!config.has_sac()) return;
  episodes_.emplace(folder_, checkpoint_.replay, std::uint64_t(config.sac().replay_steps()),
                    std::uint64_t(config.runtime().checkpoint_keep()));
}

std::string FileRunRecord::Save(const checkpoint::TrainState& state) {
  // A run that goes on from the checkpoint finds every row before it.
  if (!progress_->Flush() || !events_->Flush() || (episodes_ && !episodes_->Sync())) {
    throw std::system_error(errno, std::generic_category(), "the logs in " + folder_ + " wait");
  }
  if (episodes_) checkpoint_.replay = episodes_->position();
  checkpoint_.state = state;
  checkpoint_.logs.progress_bytes = progress_->bytes();
  checkpoint_.logs.events_bytes = events_->bytes();
  std::string path = store_->Save(checkpoint_);
  if (episodes_) episodes_->Saved();
  return path;
}

std::string FileRunRecord::LatestCheckpoint() const {
  return store_ ? store_->Latest().value_or("") : "";
}

void FileRunRecord::Started(const checkpoint::TrainState& state) {
  printer_.Started(state.version, state.steps);
}

void FileRunRecord::Excluded(const collect::trust::ExcludedHosts& hosts) {
  collect::trust::SaveExcludedHosts(hosts, collect::trust::ExcludedHostsPathOf(folder_));
}

void FileRunRecord::Learnt(const std::vector<Episode>& batch) {
  if (episodes_) episodes_->Append(batch);
}

void FileRunRecord::Updated(const algorithm::UpdateReport& report, const WallReport& wall) {
  checkpoint_.logs.wall_seconds = wall.seconds;
  const std::vector<algorithm::Metric> metrics = MetricsOf(report, wall);
  progress_->Append(metrics);
  events_->Append(report.steps, metrics);
  printer_.Updated(report, wall);
}

void FileRunRecord::Finished(const checkpoint::TrainState& state, const std::string& accounting) {
  printer_.Finished(accounting, LatestCheckpoint(), state.weights.sha256);
}

void FileRunRecord::Interrupted(const checkpoint::TrainState& state) {
  printer_.Interrupted(state.version, LatestCheckpoint());
}

}  // namespace metronome::record
