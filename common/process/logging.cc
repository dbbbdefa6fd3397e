#include "common/process/logging.h"

#include <spdlog/details/console_globals.h>
#include <spdlog/details/os.h>
#include <spdlog/pattern_formatter.h>
#include <spdlog/sinks/ansicolor_sink.h>
#include <spdlog/spdlog.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <memory>
#include <nlohmann/json.hpp>
#include <stdexcept>
#include <system_error>
#include <utility>

#include "common/process/output_thread.h"
#include "common/text/near_miss.h"

namespace metronome::process {
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

// A warning that comes just before a crash is seen, unless nobody reads.
constexpr std::chrono::milliseconds kFlush{100};

/// Standard error as a stream that never makes its writer wait.
class StandardError {
 public:
  StandardError() {
    cookie_io_functions_t functions{};
    functions.write = [](void* thread, const char* text, std::size_t size) {
      static_cast<OutputThread*>(thread)->Write(std::string(text, size));
      return static_cast<ssize_t>(size);
    };
    stream_ = fopencookie(&thread_, "w", functions);
    if (stream_ == nullptr) {
      throw std::system_error(errno, std::generic_category(), "opening the log");
    }
    // Whole lines: the sink flushes after each.
    std::setvbuf(stream_, nullptr, _IOFBF, std::size_t{1} << 16);
  }
  ~StandardError() { std::fclose(stream_); }
  StandardError(const StandardError&) = delete;
  StandardError& operator=(const StandardError&) = delete;

  [[nodiscard]] std::FILE* stream() const { return stream_; }
  OutputThread& thread() { return thread_; }

 private:
  OutputThread thread_{STDERR_FILENO};
  std::FILE* stream_ = nullptr;
};

using ColorSink = spdlog::sinks::ansicolor_sink<spdlog::details::console_mutex>;

spdlog::color_mode ColorsOfStandardError() {
  const bool shown = isatty(STDERR_FILENO) != 0 && spdlog::details::os::is_color_terminal();
  return shown ? spdlog::color_mode::always : spdlog::color_mode::never;
}

class StandardErrorSink final : private StandardError, public ColorSink {
 public:
  StandardErrorSink() : ColorSink(stream(), ColorsOfStandardError()) {}
  void flush() override {
    ColorSink::flush();
    thread().Flush(kFlush);
  }
};

void RequireKnown(const std::string& kind, const std::string& word,
                  const std::vector<std::string>& words) {
  if (std::find(words.begin(), words.end(), word) != words.end()) return;
  throw std::invalid_argument(text::UnknownName(kind, word, words));
}

}  // namespace

std::vector<std::string> LogLevels() {
  return {"trace", "debug", "info", "warning", "error", "critical", "off"};
}

std::vector<std::string> LogFormats() { return {"text", "json"}; }

void SetUpLogging(const std::string& process, const LogOptions& options) {
  RequireKnown("log level", options.level, LogLevels());
  RequireKnown("log format", options.format, LogFormats());
  auto logger = std::make_shared<spdlog::logger>(process, std::make_shared<StandardErrorSink>());
  logger->set_formatter(MakeFormatter(options.format));
  logger->set_level(spdlog::level::from_str(options.level));
  logger->flush_on(spdlog::level::warn);
  spdlog::set_default_logger(std::move(logger));
}

}  // namespace metronome::process
