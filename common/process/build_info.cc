#include "common/process/build_info.h"

#include <gnu/libc-version.h>
#include <sleef.h>

// CMakeLists.txt defines METRONOME_VERSION, METRONOME_ENGINE and METRONOME_FLAGS for this file.
namespace metronome::process {

std::string EngineName() { return METRONOME_ENGINE; }

std::string BuildIdentity() {
#if defined(__clang__)
  const std::string compiler = "clang " __clang_version__;
#else
  const std::string compiler = "gcc " __VERSION__;
#endif
  // The loaded glibc counts, not the built one: it picks its variants of functions itself.
  return "metronome " METRONOME_VERSION ", " + compiler + ", " METRONOME_FLAGS ", sleef " +
         std::to_string(SLEEF_VERSION_MAJOR) + "." + std::to_string(SLEEF_VERSION_MINOR) + "." +
         std::to_string(SLEEF_VERSION_PATCHLEVEL) + ", glibc " + gnu_get_libc_version();
}

}  // namespace metronome::process
