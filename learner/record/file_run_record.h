#pragma once

#include <optional>
#include <string>
#include <vector>

#include "common/checkpoint/checkpoint.h"
#include "common/schema/config.pb.h"
#include "learner/record/episode_log.h"
#include "learner/record/progress_log.h"
#include "learner/record/progress_printer.h"
#include "learner/record/run_record.h"
#include "learner/record/tensorboard.h"

namespace metronome::record {

/// A run's results in its folder: config.textproto, checkpoints/, progress.csv, the TensorBoard
/// file, replay/; and what the terminal shows. Files are opened by Begin.
class FileRunRecord final : public RunRecord {
 public:
  /// @param folder       exists.
  /// @param first        the checkpoint gone on from (its logs say where to cut), else one of
  ///                     version 0; config, engine, build, isa and incarnation are written from
  ///                     it.
  /// @param algorithm    Algorithm::Metrics of the run.
  /// @throws std::invalid_argument with the remedy if the run's progress.csv has other columns.
  FileRunRecord(std::string folder, checkpoint::Checkpoint first,
                std::vector<algorithm::Metric> algorithm, ProgressPrinter printer);

  void Begin() override;
  std::string Save(const checkpoint::TrainState& state) override;
  [[nodiscard]] std::string LatestCheckpoint() const override;
  void Started(const checkpoint::TrainState& state) override;
  void Excluded(const collect::trust::ExcludedHosts& hosts) override;
  void Learnt(const std::vector<Episode>& batch) override;
  void Updated(const algorithm::UpdateReport& report, const WallReport& wall) override;
  void Finished(const checkpoint::TrainState& state, const std::string& accounting) override;
  void Interrupted(const checkpoint::TrainState& state) override;

 private:
  [[nodiscard]] std::string ProgressPath() const;

  std::string folder_;
  checkpoint::Checkpoint checkpoint_;  // what Save writes; its state changes
  algorithm::UpdateReport blank_;      // whose tasks and metrics are the run's
  ProgressPrinter printer_;
  std::optional<checkpoint::CheckpointStore> store_;
  std::optional<ProgressLog> progress_;
  std::optional<TensorBoardLog> events_;
  std::optional<EpisodeLog> episodes_;  // of an algorithm with a replay
};

}  // namespace metronome::record
