#pragma once

#include "common/schema/config.pb.h"

namespace metronome::checkpoint {

/// Sets in a resolved configuration of checkpoint format 7 or before what such a file may be
/// without, to what its build did: a setting's default is that of today's runs.
void CompleteOldConfig(RunConfig& config);

}  // namespace metronome::checkpoint
