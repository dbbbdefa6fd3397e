#include "common/process/cpu_count.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <string>
#include <thread>

#include "tests/unit/support/temporary_folder.h"

namespace metronome::process {
namespace {

namespace fs = std::filesystem;

class CpuCountTest : public TemporaryFolderTest {
 protected:
  void Write(const std::string& file, const std::string& text) const {
    const fs::path path = fs::path(root_ + file);
    fs::create_directories(path.parent_path());
    std::ofstream(path) << text;
  }
  void Groups(const std::string& text) const { Write("/proc/self/cgroup", text); }
  void Mounts(const std::string& text) const { Write("/proc/self/mountinfo", text); }
};

constexpr const char* kUnified = "30 23 0:27 / /cg rw,nosuid - cgroup2 cgroup2 rw\n";
constexpr const char* kCpu = "32 31 0:29 / /cg/cpu rw,relatime - cgroup cgroup rw,cpu,cpuacct\n";

TEST_F(CpuCountTest, WithoutAQuotaThereIsNone) {
  EXPECT_EQ(CpuQuota(root_), std::nullopt);  // no /proc either
  Groups("0::/a\n");
  Mounts(kUnified);
  EXPECT_EQ(CpuQuota(root_), std::nullopt);
  Write("/cg/a/cpu.max", "max 100000\n");
  EXPECT_EQ(CpuQuota(root_), std::nullopt);
}

TEST_F(CpuCountTest, TheLeastQuotaOfAllGroupsAboveCounts) {
  Groups("0::/a/b/c\n");
  Mounts(kUnified);
  Write("/cg/a/b/c/cpu.max", "max 100000\n");
  Write("/cg/a/b/cpu.max", "150000 100000\n");
  Write("/cg/a/cpu.max", "400000 100000\n");
  EXPECT_EQ(CpuQuota(root_), 1.5);
  Write("/cg/a/cpu.max", "50000 100000\n");
  EXPECT_EQ(CpuQuota(root_), 0.5);
}

TEST_F(CpuCountTest, TheFirstVersionOfControlGroupsCountsToo) {
  Groups("5:cpuset:/other\n2:cpu,cpuacct:/a\n0::/\n");
  Mounts(std::string(kCpu) + kUnified);
  Write("/cg/cpu/a/cpu.cfs_quota_us", "-1\n");
  Write("/cg/cpu/a/cpu.cfs_period_us", "100000\n");
  EXPECT_EQ(CpuQuota(root_), std::nullopt);
  Write("/cg/cpu/a/cpu.cfs_quota_us", "200000\n");
  EXPECT_EQ(CpuQuota(root_), 2.0);
}

TEST_F(CpuCountTest, AContainerSeesItsOwnGroupWhereAllAreMounted) {
  // The mount shows the container's group alone, under the name that the host gives it.
  Groups("2:cpu:/docker/1234\n");
  Mounts("32 31 0:29 /docker/1234 /cg/cpu ro - cgroup cgroup rw,cpu\n");
  Write("/cg/cpu/cpu.cfs_quota_us", "50000\n");
  Write("/cg/cpu/cpu.cfs_period_us", "100000\n");
  EXPECT_EQ(CpuQuota(root_), 0.5);
  // With a group below it.
  Groups("2:cpu:/docker/1234/job\n");
  Write("/cg/cpu/job/cpu.cfs_quota_us", "20000\n");
  Write("/cg/cpu/job/cpu.cfs_period_us", "100000\n");
  EXPECT_EQ(CpuQuota(root_), 0.2);
  // With a namespace that the process has left behind.
  Groups("2:cpu:/../..\n");
  EXPECT_EQ(CpuQuota(root_), 0.5);
}

TEST_F(CpuCountTest, MoreThreadsThanCpusAreWarnedOfByName) {
  EXPECT_GE(UsableCpus(), 1);
  EXPECT_LE(UsableCpus(), static_cast<int>(std::thread::hardware_concurrency()));
  EXPECT_EQ(TooManyThreads(UsableCpus(), "--threads"), std::nullopt);
  const auto warning = TooManyThreads(UsableCpus() + 1, "--threads");
  ASSERT_TRUE(warning);
  EXPECT_NE(warning->find("--threads"), std::string::npos) << *warning;
}

}  // namespace
}  // namespace metronome::process
