#include "common/process/output_thread.h"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <array>
#include <chrono>
#include <optional>
#include <stdexcept>
#include <string>
#include <thread>

namespace metronome::process {
namespace {

using std::chrono::milliseconds;
using std::chrono::steady_clock;

constexpr milliseconds kLong{60'000};

/// A pipe whose reader reads when the test says so.
class OutputThreadTest : public ::testing::Test {
 protected:
  OutputThreadTest() {
    std::array<int, 2> ends{};
    if (pipe(ends.data()) != 0) throw std::runtime_error("no pipe");
    read_ = ends[0];
    write_ = ends[1];
    capacity_ = static_cast<std::size_t>(fcntl(write_, F_GETPIPE_SZ));
  }
  ~OutputThreadTest() override {
    CloseWriter();
    close(read_);
  }

  void CloseWriter() {
    if (write_ >= 0) close(write_);
    write_ = -1;
  }

  [[nodiscard]] std::string Read(std::size_t size) const {
    std::string text(size, '\0');
    for (std::size_t got = 0; got < size;) {
      got += static_cast<std::size_t>(read(read_, text.data() + got, size - got));
    }
    return text;
  }

  [[nodiscard]] std::string ReadToTheEnd() const {
    std::string all;
    std::array<char, 4096> block{};
    for (ssize_t got = 0; (got = read(read_, block.data(), block.size())) > 0;) {
      all.append(block.data(), static_cast<std::size_t>(got));
    }
    return all;
  }

  /// A line of `size` bytes that begins with `number`.
  static std::string Line(std::size_t number, std::size_t size) {
    std::string line = std::to_string(number);
    line.resize(size - 1, '.');
    return line + "\n";
  }

  int read_ = -1, write_ = -1;
  std::size_t capacity_ = 0;
};

TEST_F(OutputThreadTest, AllIsWrittenInOrderBeforeItEnds) {
  std::string expected;
  {
    OutputThread output(write_);
    for (std::size_t i = 0; i < 100; ++i) {
      output.Write(Line(i, 20));
      expected += Line(i, 20);
    }
    EXPECT_TRUE(output.Flush(kLong));
  }
  CloseWriter();
  EXPECT_EQ(ReadToTheEnd(), expected);
}

TEST_F(OutputThreadTest, AReaderWhoStandsStillHoldsUpNobodyAndTheNewestIsKept) {
  const std::size_t lines = 4 * (OutputThread::kMostWaiting + capacity_) / 1000;
  std::optional<OutputThread> output(write_);
  output->Write(Line(0, 1000));
  EXPECT_TRUE(output->Flush(kLong));
  for (std::size_t i = 1; i < lines; ++i) output->Write(Line(i, 1000));  // would block for ever
  EXPECT_FALSE(output->Flush(milliseconds(1)));
  const auto begin = steady_clock::now();
  for (int i = 0; i < 100; ++i) EXPECT_FALSE(output->Flush(kLong)) << "known to stand still";
  EXPECT_LT(steady_clock::now() - begin, kLong);
  // The reader wakes up: first what was in the pipe, then the newest of the rest.
  EXPECT_TRUE(Read(2 * capacity_).starts_with(Line(0, 1000)));
  std::thread rest([&] {
    const std::string all = ReadToTheEnd();
    EXPECT_TRUE(all.ends_with(Line(lines - 1, 1000)));
    EXPECT_LE(all.size(), OutputThread::kMostWaiting);
  });
  output.reset();
  CloseWriter();
  rest.join();
}

TEST_F(OutputThreadTest, ItsEndDoesNotWaitForAReaderWhoStandsStill) {
  const auto begin = steady_clock::now();
  {
    OutputThread output(write_);
    output.Write(std::string(2 * capacity_, 'x'));
  }
  EXPECT_GE(steady_clock::now() - begin, OutputThread::kFarewell);
  EXPECT_LT(steady_clock::now() - begin, OutputThread::kFarewell + kLong);
  // Its thread is still writing: let it, before the descriptor may be another file.
  EXPECT_EQ(Read(2 * capacity_), std::string(2 * capacity_, 'x'));
}

TEST_F(OutputThreadTest, WhatCannotBeWrittenIsDropped) {
  const int full = open("/dev/full", O_WRONLY);
  ASSERT_GE(full, 0);
  {
    OutputThread output(full);
    output.Write("lost\n");
    EXPECT_TRUE(output.Flush(kLong));
  }
  close(full);
}

}  // namespace
}  // namespace metronome::process
