#include "common/process/build_info.h"

#include <gnu/libc-version.h>

#include <Eigen/Core>

// CMakeLists.txt defines METRONOME_VERSION, METRONOME_ENGINE and METRONOME_FLAGS for this file.
namespace metronome::process {

std::string EngineName() { return METRONOME_ENGINE; }

std::string BuildIdentity() {
#if defined(__clang__)
  const std::string compiler = "clang " __clang_version__;
#else
  const std::string compiler = "gcc " __VERSION__;
#endif
  // glibc picks variants of exp, log and the like itself: the loaded one counts, not the built one.
  return "metronome " METRONOME_VERSION ", " + compiler + ", " METRONOME_FLAGS ", eigen " +
         std::to_string(EIGEN_WORLD_VERSION) + "." + std::to_string(EIGEN_MAJOR_VERSION) + "." +
         std::to_string(EIGEN_MINOR_VERSION) + ", glibc " + gnu_get_libc_version();
}

}  // namespace metronome::process
