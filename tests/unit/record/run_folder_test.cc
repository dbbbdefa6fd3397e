#include "learner/record/run_folder.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <atomic>
#include <filesystem>
#include <fstream>
#include <memory>
#include <string>
#include <thread>
#include <vector>

#include "common/process/files.h"
#include "learner/collect/trust/excluded_hosts.h"
#include "tests/unit/support/temporary_folder.h"

namespace metronome::record {
namespace {

class RunFolderTest : public TemporaryFolderTest {
 protected:
  std::string Path() const { return root_ + "/runs/name"; }
};

TEST_F(RunFolderTest, TheIncarnationGrowsAtEachStart) {
  std::filesystem::create_directories(Path());
  std::ofstream(Path() + "/config.textproto") << "seed: 1\n";
  EXPECT_EQ(RunFolder(Path()).NextIncarnation(0), 1U);
  EXPECT_EQ(RunFolder(Path()).NextIncarnation(0), 2U);
  EXPECT_EQ(RunFolder(Path()).NextIncarnation(1), 3U);
  EXPECT_EQ(RunFolder(Path()).NextIncarnation(9), 10U) << "the checkpoint had seen more";
}

TEST_F(RunFolderTest, ALostOrDamagedCounterGoesOnFromTheCheckpoint) {
  RunFolder folder(Path());
  std::ofstream(folder.File("incarnation")) << "what?\n";
  EXPECT_EQ(folder.NextIncarnation(4), 5U);
  std::filesystem::remove(folder.File("incarnation"));
  EXPECT_EQ(folder.NextIncarnation(4), 5U);
  std::ofstream(folder.File("incarnation"), std::ios::trunc);
  EXPECT_EQ(folder.NextIncarnation(4), 5U);
  std::ofstream(folder.File("incarnation")) << "18446744073709551615\n";  // the next would be 0
  EXPECT_EQ(folder.NextIncarnation(4), 5U);
  std::filesystem::remove(folder.File("incarnation"));
  std::filesystem::create_directory(folder.File("incarnation"));
  EXPECT_EQ(folder.NextIncarnation(4), 5U);
  EXPECT_EQ(folder.NextIncarnation(4), 6U);
}

TEST_F(RunFolderTest, ASecondLearnerIsRefusedNamingTheFirstUntilThatEnds) {
  auto first = std::make_unique<RunFolder>(Path());
  try {
    RunFolder second(Path());
    FAIL() << "two hold the folder";
  } catch (const RunFolderBusy& error) {
    EXPECT_NE(std::string(error.what()).find("process " + std::to_string(getpid())),
              std::string::npos)
        << error.what();
  }
  first.reset();
  EXPECT_NO_THROW(RunFolder{Path()});
}

// A start that is refused removes what it made, while the next one begins.
TEST_F(RunFolderTest, AmongManyStartsAtOnceOneAtATimeHasTheFolder) {
  constexpr int kStarts = 3000;
  std::atomic<int> holders{0};
  std::atomic<int> held{0};
  const auto start_often = [&] {
    for (int i = 0; i < kStarts; ++i) {
      try {
        const RunFolder folder(Path());
        EXPECT_EQ(++holders, 1);
        ++held;
        --holders;
      } catch (const RunFolderBusy&) {
      } catch (const std::exception& error) {
        ADD_FAILURE() << error.what();
      }
    }
  };
  std::vector<std::thread> learners;
  for (int i = 0; i < 4; ++i) learners.emplace_back(start_often);
  for (std::thread& learner : learners) learner.join();
  EXPECT_GE(held, kStarts / 10);
}

TEST_F(RunFolderTest, AFolderThatWasNeverUsedVanishesWithItsHolder) {
  RunFolder(Path()).NextIncarnation(0);
  EXPECT_FALSE(std::filesystem::exists(Path()));
  {
    RunFolder folder(Path());
    folder.NextIncarnation(0);
    std::ofstream(folder.File("config.textproto")) << "seed: 1\n";
  }
  EXPECT_TRUE(std::filesystem::exists(Path() + "/incarnation"));
}

TEST_F(RunFolderTest, AFolderThatCannotBeMadeIsNamed) {
  std::ofstream(root_ + "/runs") << "a file\n";
  try {
    RunFolder folder(Path());
    FAIL();
  } catch (const std::system_error& error) {
    EXPECT_NE(std::string(error.what()).find(root_ + "/runs"), std::string::npos) << error.what();
  }
}

TEST_F(RunFolderTest, ExcludedHostsAreReadAsTheyWereWritten) {
  const std::string path = collect::trust::ExcludedHostsPathOf(root_);
  EXPECT_TRUE(collect::trust::LoadExcludedHosts(path).empty());
  const collect::trust::ExcludedHosts hosts = {{"a", "one \"reason\""}, {"b\n", "another"}};
  collect::trust::SaveExcludedHosts(hosts, path);
  EXPECT_EQ(collect::trust::LoadExcludedHosts(path), hosts);
  EXPECT_NO_THROW(collect::trust::SaveExcludedHosts({{"\xff", "no text"}}, path));
}

TEST_F(RunFolderTest, ExcludedHostsMayBeSavedWithAByteOrderMark) {
  const std::string path = collect::trust::ExcludedHostsPathOf(root_);
  std::ofstream(path) << "\xef\xbb\xbf{\"a\": \"reason\"}\r\n";
  EXPECT_EQ(collect::trust::LoadExcludedHosts(path),
            (collect::trust::ExcludedHosts{{"a", "reason"}}));
}

TEST_F(RunFolderTest, AnExclusionFileOfAnotherFormIsNamedWithTheRemedy) {
  const std::string path = collect::trust::ExcludedHostsPathOf(root_);
  for (const char* content : {"", "{", "[\"a\"]", "{\"a\": 1}"}) {
    std::ofstream(path, std::ios::trunc) << content;
    try {
      collect::trust::LoadExcludedHosts(path);
      FAIL() << content;
    } catch (const std::invalid_argument& error) {
      EXPECT_NE(std::string(error.what()).find(path + " does not say"), std::string::npos);
    }
  }
}

}  // namespace
}  // namespace metronome::record
