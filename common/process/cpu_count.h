#pragma once

#include <optional>
#include <string>

namespace metronome::process {

/// CPUs that the control groups of this process give it, 1.5 say: the least quota of its group and
/// all above it (cgroup v2 cpu.max, v1 cpu.cfs_quota_us over cpu.cfs_period_us); none where no
/// group has one.
/// @param root  what stands before /proc/self/ and the mount points; for tests.
std::optional<double> CpuQuota(const std::string& root = "");

/// CPUs that this process can keep busy: those it may run on, or its quota rounded up if that is
/// less. At least 1.
int UsableCpus();

/// A line for people if `threads` are more than UsableCpus(), which makes them slower than fewer
/// would be; std::nullopt otherwise. @param option  what sets the count.
std::optional<std::string> TooManyThreads(int threads, const std::string& option);

}  // namespace metronome::process
