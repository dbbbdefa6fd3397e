#include "tests/bench/swarm_process.h"

#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <csignal>
#include <cstdio>
#include <ctime>
#include <exception>
#include <stdexcept>

namespace metronome::bench {
namespace {

double SecondsOf(clockid_t clock) {
  timespec time{};
  clock_gettime(clock, &time);
  return double(time.tv_sec) + 1e-9 * double(time.tv_nsec);
}

double SecondsOf(const timeval& time) { return double(time.tv_sec) + 1e-6 * double(time.tv_usec); }

[[noreturn]] void RunAndExit(const std::function<void()>& body) {
  prctl(PR_SET_PDEATHSIG, SIGKILL);  // no child outlives us
  try {
    body();
  } catch (const std::exception& error) {
    std::fprintf(stderr, "swarm: %s\n", error.what());
    _exit(1);
  }
  _exit(0);
}

}  // namespace

int Fork(const std::function<void()>& body) {
  const pid_t child = fork();
  if (child < 0) throw std::runtime_error("fork failed");
  if (child == 0) RunAndExit(body);
  return child;
}

double WaitForAll(const std::vector<int>& children) {
  double seconds = 0;
  bool good = true;
  for (const int child : children) {
    int status = 0;
    rusage usage{};
    good = wait4(child, &status, 0, &usage) == child && status == 0 && good;
    seconds += SecondsOf(usage.ru_utime) + SecondsOf(usage.ru_stime);
  }
  if (!good) throw std::runtime_error("a child did not end well");
  return seconds;
}

double ProcessSeconds() { return SecondsOf(CLOCK_PROCESS_CPUTIME_ID); }
double ThreadSeconds() { return SecondsOf(CLOCK_THREAD_CPUTIME_ID); }

Pipe::Pipe() {
  if (pipe(ends_) != 0) throw std::runtime_error("pipe failed");
}

Pipe::~Pipe() {
  close(ends_[0]);
  close(ends_[1]);
}

void Pipe::WriteBytes(const void* data, unsigned long bytes) {
  if (write(ends_[1], data, bytes) != ssize_t(bytes)) throw std::runtime_error("pipe: write");
}

void Pipe::ReadBytes(void* data, unsigned long bytes) {
  if (read(ends_[0], data, bytes) != ssize_t(bytes)) throw std::runtime_error("pipe: read");
}

}  // namespace metronome::bench
