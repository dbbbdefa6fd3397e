/// Checkpoint files. Random bytes do not get past the hash, so every other input is framed as a
/// checkpoint whose payload it is.
#include <cstdint>
#include <string>

#include "common/checkpoint/checkpoint.h"
#include "tests/fuzz/checkpoint_frame.h"
#include "tests/unit/support/environments.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  if (size == 0) return 0;
  std::string bytes(reinterpret_cast<const char*>(data) + 1, size - 1);
  if ((data[0] & 1) != 0) bytes = metronome::fuzz::Framed(bytes);
  try {
    const metronome::checkpoint::Checkpoint checkpoint =
        metronome::checkpoint::DecodeCheckpoint(bytes, "fuzz", metronome::test::Describe);
    (void)metronome::checkpoint::EncodeCheckpoint(checkpoint);
  } catch (const metronome::checkpoint::CheckpointError&) {
  }
  return 0;
}
