#include "learner/record/tensorboard.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <bit>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <map>

#include "common/process/files.h"
#include "learner/record/tensorboard_event.pb.h"

namespace metronome::record {
namespace {

std::vector<algorithm::Metric> Metrics(double value) {
  return {{"return", "train/return", value, ""},
          {"epochs", "ppo/epochs", std::uint64_t{10}, ""},
          {"fps", "wall/fps", 900.5, ""}};
}

/// Reads a file as TensorBoard does; stops the test at a frame that is not right.
std::vector<tensorboard::Event> ReadEvents(const std::string& path) {
  const std::string content = process::ReadFile(path);
  std::vector<tensorboard::Event> events;
  const auto masked = [](std::string_view bytes) {
    const std::uint32_t crc = Crc32c(bytes);
    return ((crc >> 15) | (crc << 17)) + 0xa282ead8U;
  };
  for (std::size_t at = 0; at < content.size();) {
    std::uint64_t length = 0;
    std::uint32_t length_crc = 0, data_crc = 0;
    std::memcpy(&length, &content.at(at), 8);
    std::memcpy(&length_crc, &content.at(at + 8), 4);
    std::memcpy(&data_crc, &content.at(at + 12 + length), 4);
    const auto bytes = std::string_view(content);
    EXPECT_EQ(length_crc, masked(bytes.substr(at, 8)));
    EXPECT_EQ(data_crc, masked(bytes.substr(at + 12, length)));
    EXPECT_TRUE(events.emplace_back().ParseFromString(content.substr(at + 12, length)));
    at += 16 + length;
  }
  return events;
}

class TensorBoardTest : public ::testing::Test {
 protected:
  void SetUp() override { std::filesystem::remove(path_); }
  void TearDown() override { std::filesystem::remove(path_); }
  const std::string path_ =
      ::testing::TempDir() + "metronome_" + std::to_string(getpid()) + ".tfevents";
};

TEST(Crc32cTest, MatchesThePublishedVectors) {
  EXPECT_EQ(Crc32c("123456789"), 0xe3069283U);
  EXPECT_EQ(Crc32c(std::string(32, '\0')), 0x8a9136aaU);    // RFC 3720, B.4
  EXPECT_EQ(Crc32c(std::string(32, '\xff')), 0x62a8ab43U);  // RFC 3720, B.4
}

TEST_F(TensorBoardTest, AFileBeginsWithItsVersion) {
  TensorBoardLog log(path_, 0);
  const auto events = ReadEvents(path_);
  ASSERT_EQ(events.size(), 1u);
  EXPECT_EQ(events[0].file_version(), "brain.Event:2");
  EXPECT_GT(events[0].wall_time(), 1.6e9);
}

TEST_F(TensorBoardTest, FramesCarryTensorBoardsMaskedChecksums) {
  TensorBoardLog log(path_, 0);
  // 24 bytes of data; the checksum is what TensorBoard's own masked_crc32c gives for that length.
  EXPECT_EQ(process::ReadFile(path_).substr(0, 12),
            std::string("\x18\0\0\0\0\0\0\0\xa3\x7f\x4b\x22", 12));
}

TEST_F(TensorBoardTest, EachUpdateIsOneEventOfScalarsOverSteps) {
  TensorBoardLog log(path_, 0);
  log.Append(8000, Metrics(1.5));
  log.Append(16000, Metrics(2.5));
  const auto events = ReadEvents(path_);
  ASSERT_EQ(events.size(), 3u);
  EXPECT_EQ(events[1].step(), 8000);
  EXPECT_EQ(events[2].step(), 16000);
  std::map<std::string, float> values;
  for (const auto& value : events[2].summary().value()) values[value.tag()] = value.simple_value();
  const std::map<std::string, float> expected = {
      {"train/return", 2.5F}, {"ppo/epochs", 10.0F}, {"wall/fps", 900.5F}};
  EXPECT_EQ(values, expected);
}

TEST_F(TensorBoardTest, ResumingCutsBackToTheCheckpoint) {
  std::uint64_t at_one = 0;
  {
    TensorBoardLog log(path_, 0);
    log.Append(8000, Metrics(1));
    at_one = log.bytes();
    log.Append(16000, Metrics(2));
  }
  TensorBoardLog log(path_, at_one);
  log.Append(16000, Metrics(3));
  const auto events = ReadEvents(path_);
  ASSERT_EQ(events.size(), 3u);
  EXPECT_EQ(events[2].summary().value(0).simple_value(), 3.0F);
}

TEST_F(TensorBoardTest, AFileThatEndsAmidARecordIsKeptUpToItsLastWholeOne) {
  {
    TensorBoardLog log(path_, 0);
    log.Append(8000, Metrics(1));
  }
  const std::string whole = process::ReadFile(path_);
  for (const std::size_t extra : {1u, 11u, 12u, 20u}) {
    std::ofstream(path_, std::ios::binary) << whole << whole.substr(0, extra);
    TensorBoardLog log(path_, 100000);
    EXPECT_EQ(process::ReadFile(path_), whole) << extra;
  }
  std::ofstream(path_, std::ios::binary | std::ios::app) << std::string(20, '\xff');
  EXPECT_EQ(TensorBoardLog(path_, 100000).bytes(), whole.size());
}

}  // namespace
}  // namespace metronome::record
