#pragma once

#include <gtest/gtest.h>
#include <unistd.h>

#include <cerrno>
#include <filesystem>
#include <string>
#include <system_error>

namespace metronome {

/// Tests that have a folder of their own, which is removed after each with all in it.
class TemporaryFolderTest : public ::testing::Test {
 protected:
  TemporaryFolderTest() {
    std::string pattern = ::testing::TempDir() + "metronome_XXXXXX";
    if (mkdtemp(pattern.data()) == nullptr)
      throw std::system_error(errno, std::generic_category(), "mkdtemp");
    root_ = pattern;
  }
  ~TemporaryFolderTest() override { std::filesystem::remove_all(root_); }

  std::string root_;
};

}  // namespace metronome
