#include "common/dds/workarounds/surroundings.h"

#include <spdlog/spdlog.h>

#include <array>
#include <cstdlib>
#include <filesystem>
#include <mutex>
#include <string>
#include <system_error>

namespace metronome::dds::workarounds {
namespace {

// All that Fast DDS 2.9 reads but FASTDDS_PKCS11_PIN, which is for keys that are not in files.
constexpr std::array kVariables = {"ROS_DISCOVERY_SERVER", "FASTRTPS_DEFAULT_PROFILES_FILE",
                                   "FASTDDS_ENVIRONMENT_FILE", "FASTDDS_STATISTICS"};
constexpr const char* kProfiles = "DEFAULT_FASTRTPS_PROFILES.xml";  // of the current folder
constexpr const char* kSkipProfiles = "SKIP_DEFAULT_XML_FILE";      // "1" leaves it unread

/// Takes them away. @return which were set, in the order of kVariables.
std::array<bool, kVariables.size()> TakeAway() noexcept {
  std::array<bool, kVariables.size()> was_set{};
  for (std::size_t i = 0; i < kVariables.size(); ++i) {
    const char* value = std::getenv(kVariables[i]);
    was_set[i] = value != nullptr && *value != '\0';
    unsetenv(kVariables[i]);
  }
  setenv(kSkipProfiles, "1", 1);
  return was_set;
}

const std::array<bool, kVariables.size()> kWasSet = TakeAway();

std::string Ignored() {
  std::string names;
  const auto add = [&names](const std::string& name) {
    names += (names.empty() ? "" : ", ") + name;
  };
  for (std::size_t i = 0; i < kVariables.size(); ++i) {
    if (kWasSet[i]) add(kVariables[i]);
  }
  std::error_code unknown;
  if (std::filesystem::exists(kProfiles, unknown)) add(std::string(kProfiles) + " of this folder");
  return names;
}

}  // namespace

void WarnOfIgnoredSurroundings() {
  static std::once_flag once;
  std::call_once(once, [] {
    const std::string ignored = Ignored();
    if (ignored.empty()) return;
    spdlog::warn(
        "not used: {}. Options alone say how a run is joined: --network, --transport, --domain, "
        "--discovery-server",
        ignored);
  });
}

}  // namespace metronome::dds::workarounds
