#pragma once

/// Processor features that this build needs: data alone, so that a processor without them can read
/// it.
namespace metronome::process {

/// Names of processor features, as compilers spell them; a null pointer ends them.
extern const char* const kProcessorNeeds[];

/// Why: the build's -march and engine, for people.
extern const char* const kProcessorNeedsReason;

}  // namespace metronome::process
