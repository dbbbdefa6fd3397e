#pragma once

#include <string>
#include <vector>

#include "actor/play/evaluate.h"
#include "common/checkpoint/checkpoint.h"
#include "common/schema/config.pb.h"

namespace metronome::play {

/// Every way in which an evaluation's episodes are played otherwise than the checkpoint's training
/// episodes, one sentence each, with the option that plays them alike where there is one: the
/// environment's configuration, the placements' seed, who acts when, engine and libraries. Not
/// named: the mean action, and that random placements and permutations of shuffled heads are new
/// ones; that is what an evaluation is for.
/// @param played  configuration of the evaluation, see ConfigToEvaluate.
std::vector<std::string> DifferencesFromTraining(const checkpoint::Checkpoint& checkpoint,
                                                 const EvaluateOptions& options,
                                                 const RunConfig& played);

}  // namespace metronome::play
