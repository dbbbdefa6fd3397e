#include "common/process/ignored_signals.h"

#include <csignal>

namespace metronome::process {

void IgnoreFileSizeLimit() { std::signal(SIGXFSZ, SIG_IGN); }

void IgnoreLostReaders() { std::signal(SIGPIPE, SIG_IGN); }

}  // namespace metronome::process
