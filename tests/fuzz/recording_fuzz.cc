/// Recordings of the official environment, plain or gzip.
#include <sys/mman.h>
#include <unistd.h>

#include <cstdint>
#include <cstdlib>
#include <stdexcept>
#include <string>

#include "actor/replay/recording.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const int file = memfd_create("recording", MFD_CLOEXEC);
  if (file < 0 || write(file, data, size) != static_cast<ssize_t>(size)) std::abort();
  try {
    (void)metronome::replay::ReadRecording("/proc/self/fd/" + std::to_string(file));
  } catch (const std::invalid_argument&) {
  }
  close(file);
  return 0;
}
