#include "common/process/process_identity.h"

#include <unistd.h>

#include <array>
#include <random>

namespace metronome::process {

std::uint64_t RandomId() {
  std::random_device device;
  return (std::uint64_t{device()} << 32) | device();
}

std::string HostName() {
  std::array<char, 256> name{};
  return gethostname(name.data(), name.size() - 1) == 0 ? name.data() : "unknown";
}

}  // namespace metronome::process
