/// Configurations: files in text format, --set arguments, and the bytes in a run description.
#include <cstdint>
#include <string>

#include "common/config/config.h"
#include "common/config/config_file.h"
#include "tests/unit/support/environments.h"

namespace {

using metronome::config::ConfigError;

void Text(const std::string& text) {
  metronome::RunConfig config = metronome::config::ParseConfigText(text, "fuzz").config;
  metronome::config::CompleteSpec(config, metronome::test::Describe);
  config = metronome::config::Resolve(config);
  metronome::config::Validate(config);
  // A configuration that passes is printed and read again on resuming.
  metronome::config::Validate(
      metronome::config::ParseConfigText(metronome::config::PrintConfig(config), "again").config);
}

void Settings(const std::string& text) {
  metronome::config::ConfigDraft draft;
  draft.SetFromArgument(text);
  (void)draft.Finish(metronome::test::Describe);
}

void Bytes(const std::string& bytes) {
  metronome::RunConfig config;
  if (config.ParseFromString(bytes)) metronome::config::Validate(config);
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  if (size == 0) return 0;
  const std::string rest(reinterpret_cast<const char*>(data) + 1, size - 1);
  try {
    switch (data[0] % 3) {
      case 0:
        Text(rest);
        break;
      case 1:
        Settings(rest);
        break;
      default:
        Bytes(rest);
    }
  } catch (const ConfigError&) {
  }
  return 0;
}
