#pragma once

/// Signals by which the kernel ends a process that cannot write. Ignored, the write fails instead
/// (EFBIG, EPIPE), and whoever writes decides what that means. Call at the start of main, before
/// threads.
namespace metronome::process {

/// SIGXFSZ: a file is as large as `ulimit -f` allows, which is a kind of full disk.
void IgnoreFileSizeLimit();

/// SIGPIPE: whoever read our output has left. For what goes on without readers.
void IgnoreLostReaders();

}  // namespace metronome::process
