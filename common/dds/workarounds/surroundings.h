#pragma once

namespace metronome::dds::workarounds {

/// Fast DDS 2.9 takes discovery servers, profiles, statistics and settings of its log from
/// environment variables and from a file in the current folder; any of them can keep a participant
/// from others, and the last ones change what a run says. Options alone decide here: the variables
/// are taken out of the environment before main() begins, while the process has one thread.
///
/// Warns, once a process, of what is not used and what does the same.
void WarnOfIgnoredSurroundings();

}  // namespace metronome::dds::workarounds
