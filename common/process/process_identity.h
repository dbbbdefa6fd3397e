#pragma once

#include <cstdint>
#include <string>

/// Names that tell one process from the others of a run. Thread-safe.
namespace metronome::process {

/// 64 bits from the system, anew with each call: of ids, and of keys that nobody else may know.
std::uint64_t RandomId();

/// This machine's own name.
std::string HostName();

}  // namespace metronome::process
