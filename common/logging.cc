#include "common/logging.h"

#include <spdlog/pattern_formatter.h>
#include <spdlog/sinks/stdout_color_sinks.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <memory>
#include <nlohmann/json.hpp>
#include <stdexcept>
#include <utility>

#include "common/near_miss.h"

namespace metronome {
namespace {

/// The message as a JSON string, whatever its bytes are.
class JsonMessage final : public spdlog::custom_flag_formatter {
 public:
  void format(const spdlog::details::log_msg& message, const std::tm& /*time*/,
              spdlog::memory_buf_t& out) override {
    using Json = nlohmann::json;
    const Json text = std::string(message.payload.data(), message.payload.size());
    const std::string quoted = text.dump(-1, ' ', false, Json::error_handler_t::replace);
    out.append(quoted.data(), quoted.data() + quoted.size());
  }
  [[nodiscard]] std::unique_ptr<custom_flag_formatter> clone() const override {
    return std::make_unique<JsonMessage>();
  }
};

std::unique_ptr<spdlog::formatter> MakeFormatter(const std::string& format) {
  if (format == "text") {
    return std::make_unique<spdlog::pattern_formatter>("%H:%M:%S.%e %n[%P] %^%l%$: %v");
  }
  auto made = std::make_unique<spdlog::pattern_formatter>(spdlog::pattern_time_type::utc);
  made->add_flag<JsonMessage>('*').set_pattern(
      R"({"time":"%Y-%m-%dT%H:%M:%S.%eZ","level":"%l","process":"%n","pid":%P,"message":%*})");
  return made;
}

void RequireKnown(const std::string& kind, const std::string& word,
                  const std::vector<std::string>& words) {
  if (std::find(words.begin(), words.end(), word) != words.end()) return;
  throw std::invalid_argument(UnknownName(kind, word, words));
}

}  // namespace

std::vector<std::string> LogLevels() {
  return {"trace", "debug", "info", "warning", "error", "critical", "off"};
}

std::vector<std::string> LogFormats() { return {"text", "json"}; }

void SetUpLogging(const std::string& process, const LogOptions& options) {
  RequireKnown("log level", options.level, LogLevels());
  RequireKnown("log format", options.format, LogFormats());
  auto logger = std::make_shared<spdlog::logger>(
      process, std::make_shared<spdlog::sinks::stderr_color_sink_mt>());
  logger->set_formatter(MakeFormatter(options.format));
  logger->set_level(spdlog::level::from_str(options.level));
  logger->flush_on(spdlog::level::warn);
  spdlog::set_default_logger(std::move(logger));
}

}  // namespace metronome
