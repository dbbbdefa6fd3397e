#pragma once

/// What a processor must have to run this build: data alone, so that one that lacks it can read it.
namespace metronome::process {

/// Names of processor features, as compilers spell them; a null pointer ends them.
extern const char* const kProcessorNeeds[];

/// Why: the build's -march and engine, for people.
extern const char* const kProcessorNeedsReason;

}  // namespace metronome::process
