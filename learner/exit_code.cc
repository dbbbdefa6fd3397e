#include "learner/exit_code.h"

#include <spdlog/spdlog.h>

#include <exception>
#include <stdexcept>

#include "common/checkpoint/checkpoint.h"
#include "common/process/exit_codes.h"
#include "learner/record/run_folder.h"
#include "learner/run/run_start.h"

namespace metronome {
namespace {

int CodeOf(const std::exception& error) {
  if (dynamic_cast<const RunFolderBusy*>(&error) != nullptr) return kExitRival;
  // Another start may find it readable.
  if (dynamic_cast<const CheckpointUnreadable*>(&error) != nullptr) return kExitFailure;
  const bool for_ever = dynamic_cast<const CheckpointError*>(&error) != nullptr ||
                        dynamic_cast<const CannotStart*>(&error) != nullptr ||
                        dynamic_cast<const std::invalid_argument*>(&error) != nullptr;
  return for_ever ? kExitUsage : kExitFailure;
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
    return kExitFailure;
  }
}

}  // namespace metronome
