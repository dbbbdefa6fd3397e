#include "learner/exit_code.h"

#include <spdlog/spdlog.h>

#include <exception>
#include <stdexcept>

#include "common/checkpoint/checkpoint.h"
#include "common/process/exit_codes.h"
#include "learner/record/run_folder.h"
#include "learner/run/run_start.h"

namespace metronome::learner {
namespace {

int CodeOf(const std::exception& error) {
  if (dynamic_cast<const record::RunFolderBusy*>(&error) != nullptr) return process::kExitRival;
  // Another start may find it readable.
  if (dynamic_cast<const checkpoint::CheckpointUnreadable*>(&error) != nullptr)
    return process::kExitFailure;
  const bool for_ever = dynamic_cast<const checkpoint::CheckpointError*>(&error) != nullptr ||
                        dynamic_cast<const run::CannotStart*>(&error) != nullptr ||
                        dynamic_cast<const std::invalid_argument*>(&error) != nullptr;
  return for_ever ? process::kExitUsage : process::kExitFailure;
}

}  // namespace

int CodeOfStart(const std::function<int()>& start) {
  try {
    return start();
  } catch (const std::exception& error) {
    spdlog::error("{}", error.what());
    return CodeOf(error);
  }
}

int CodeOfServing(const std::function<int()>& serve) {
  try {
    return serve();
  } catch (const std::exception& error) {
    spdlog::error("{}", error.what());
    return process::kExitFailure;
  }
}

}  // namespace metronome::learner
