#include "common/process/cpu_times.h"

#include <cmath>
#include <cstdio>
#include <ctime>

namespace metronome::process {
namespace {

constexpr std::array<const char*, static_cast<std::size_t>(CpuUse::kCount)> kNames = {
    "set-up", "physics", "reset", "policy", "rollout", "send", "check", "update", "save"};

double Seconds(clockid_t clock) {
  timespec time{};
  clock_gettime(clock, &time);
  return static_cast<double>(time.tv_sec) + 1e-9 * static_cast<double>(time.tv_nsec);
}

std::string Rounded(double seconds) {
  std::array<char, 32> text{};
  std::snprintf(text.data(), text.size(), "%.2f", seconds);
  return text.data();
}

}  // namespace

CpuTimes& CpuTimes::OfProcess() {
  static CpuTimes times;
  return times;
}

void CpuTimes::Add(CpuUse use, double seconds) {
  nanoseconds_[static_cast<std::size_t>(use)] += std::llround(seconds * 1e9);
}

double CpuTimes::seconds(CpuUse use) const {
  return 1e-9 * static_cast<double>(nanoseconds_[static_cast<std::size_t>(use)].load());
}

std::string CpuTimes::Report() const {
  const double total = Seconds(CLOCK_PROCESS_CPUTIME_ID);
  double named = 0;
  std::string text = Rounded(total) + " CPU seconds: ";
  for (std::size_t i = 0; i < kNames.size(); ++i) {
    const double taken = seconds(static_cast<CpuUse>(i));
    if (taken <= 0) continue;
    named += taken;
    text += std::string(kNames[i]) + " " + Rounded(taken) + ", ";
  }
  return text + "rest " + Rounded(total - named);
}

double ThreadCpuSeconds() { return Seconds(CLOCK_THREAD_CPUTIME_ID); }

}  // namespace metronome::process
