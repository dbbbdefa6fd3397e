#include "common/logging.h"

#include <spdlog/sinks/stdout_color_sinks.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <memory>
#include <stdexcept>

#include "common/near_miss.h"

namespace metronome {

std::vector<std::string> LogLevels() {
  return {"trace", "debug", "info", "warning", "error", "critical", "off"};
}

void SetUpLogging(const std::string& process, const std::string& level) {
  const auto levels = LogLevels();
  if (std::find(levels.begin(), levels.end(), level) == levels.end()) {
    throw std::invalid_argument(UnknownName("log level", level, levels));
  }
  auto logger = std::make_shared<spdlog::logger>(
      process, std::make_shared<spdlog::sinks::stderr_color_sink_mt>());
  logger->set_pattern("%H:%M:%S.%e %n[%P] %^%l%$: %v");
  logger->set_level(spdlog::level::from_str(level));
  logger->flush_on(spdlog::level::warn);
  spdlog::set_default_logger(std::move(logger));
}

}  // namespace metronome
