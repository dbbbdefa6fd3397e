#include "common/process/logging.h"

#include <gtest/gtest.h>
#include <spdlog/spdlog.h>
#include <unistd.h>

#include <functional>
#include <memory>
#include <nlohmann/json.hpp>
#include <stdexcept>
#include <string>

namespace metronome::process {
namespace {

using Json = nlohmann::json;

/// The lines that `say` logs to standard error.
std::string Logged(const LogOptions& options, const std::function<void()>& say) {
  const auto before = spdlog::default_logger();
  testing::internal::CaptureStderr();
  SetUpLogging("learner", options);
  say();
  spdlog::default_logger()->flush();
  spdlog::set_default_logger(before);
  return testing::internal::GetCapturedStderr();
}

TEST(LoggingTest, AJsonLineSaysWhenHowSevereWhoAndWhat) {
  const std::string line = Logged({"info", "json"}, [] { spdlog::warn("{} is slow", "host:7"); });
  const Json said = Json::parse(line);
  EXPECT_EQ(said.at("level"), "warning");
  EXPECT_EQ(said.at("process"), "learner");
  EXPECT_EQ(said.at("pid"), getpid());
  EXPECT_EQ(said.at("message"), "host:7 is slow");
  EXPECT_EQ(said.size(), 5U);
  EXPECT_EQ(line.back(), '\n');
  EXPECT_EQ(line.find('\n'), line.size() - 1);
}

TEST(LoggingTest, TheTimeOfAJsonLineIsUtc) {
  setenv("TZ", "Asia/Tokyo", 1);
  tzset();
  const std::time_t before = std::time(nullptr);
  const std::string line = Logged({"info", "json"}, [] { spdlog::info("now"); });
  const std::time_t after = std::time(nullptr);
  unsetenv("TZ");
  tzset();
  const std::string time = Json::parse(line).at("time");
  std::tm parsed{};
  ASSERT_STREQ(strptime(time.c_str(), "%Y-%m-%dT%H:%M:%S", &parsed), time.c_str() + 19);
  EXPECT_GE(timegm(&parsed), before);
  EXPECT_LE(timegm(&parsed), after);
  EXPECT_EQ(time.size(), std::string("2026-11-25T10:20:30.123Z").size());
  EXPECT_EQ(time.back(), 'Z');
}

TEST(LoggingTest, AnyMessageIsOneJsonLine) {
  const std::string message = "a \"quoted\" path C:\\x,\nanother line\x01 \xff\xfe {}";
  const std::string line = Logged({"info", "json"}, [&] { spdlog::info("{}", message); });
  EXPECT_EQ(line.find('\n'), line.size() - 1);
  const std::string said = Json::parse(line).at("message");
  EXPECT_EQ(said, "a \"quoted\" path C:\\x,\nanother line\x01 \uFFFD\uFFFD {}");
}

TEST(LoggingTest, TextIsForPeopleAndTheDefault) {
  const std::string line = Logged({}, [] { spdlog::info("hello"); });
  const std::string end = " learner[" + std::to_string(getpid()) + "] info: hello\n";
  ASSERT_GE(line.size(), end.size());
  EXPECT_EQ(line.substr(line.size() - end.size()), end);
}

TEST(LoggingTest, WhatIsLessSevereIsNotSaid) {
  EXPECT_EQ(Logged({"warning", "json"}, [] { spdlog::info("hello"); }), "");
}

TEST(LoggingTest, UnknownWordsAreNamed) {
  EXPECT_THROW(SetUpLogging("learner", {"loud", "text"}), std::invalid_argument);
  EXPECT_THROW(SetUpLogging("learner", {"info", "xml"}), std::invalid_argument);
}

}  // namespace
}  // namespace metronome::process
