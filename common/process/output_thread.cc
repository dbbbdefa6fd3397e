#include "common/process/output_thread.h"

#include <pthread.h>
#include <unistd.h>

#include <cerrno>
#include <condition_variable>
#include <csignal>
#include <deque>
#include <string_view>
#include <system_error>
#include <thread>
#include <utility>

#include "common/process/mutex.h"

namespace metronome::process {
namespace {

/// Blocks all signals of this thread, and so of those that it starts, to the end of its scope.
class WithoutSignals {
 public:
  WithoutSignals() {
    sigset_t all;
    sigfillset(&all);
    pthread_sigmask(SIG_SETMASK, &all, &before_);
  }
  ~WithoutSignals() { pthread_sigmask(SIG_SETMASK, &before_, nullptr); }
  WithoutSignals(const WithoutSignals&) = delete;
  WithoutSignals& operator=(const WithoutSignals&) = delete;

 private:
  sigset_t before_{};
};

// A text that fails is given up: the next one may fare better.
void WriteAll(int descriptor, std::string_view text) {
  while (!text.empty()) {
    const ssize_t written = write(descriptor, text.data(), text.size());
    if (written < 0 && errno == EINTR) continue;
    if (written < 0) return;
    text.remove_prefix(static_cast<std::size_t>(written));
  }
}

}  // namespace

struct OutputThread::State {
  explicit State(int to) : descriptor(to) {}

  const int descriptor;
  Mutex mutex;
  std::condition_variable changed;
  std::deque<std::string> waiting METRONOME_GUARDED_BY(mutex);
  std::size_t bytes METRONOME_GUARDED_BY(mutex) = 0;  // that wait
  bool writing METRONOME_GUARDED_BY(mutex) = false;
  bool stuck METRONOME_GUARDED_BY(mutex) =
      false;  // Flush waited in vain, and nothing was written since
  bool closing METRONOME_GUARDED_BY(mutex) = false;

  [[nodiscard]] bool AllWritten() const METRONOME_REQUIRES(mutex) {
    return waiting.empty() && !writing;
  }
};

OutputThread::OutputThread(int descriptor) : state_(std::make_shared<State>(descriptor)) {
  const WithoutSignals none;
  try {
    std::thread([state = state_] { Work(*state); }).detach();
  } catch (const std::system_error& error) {
    throw std::system_error(error.code(), "no thread can be started for output");
  }
}

OutputThread::~OutputThread() {
  MutexLock lock(state_->mutex);
  state_->changed.wait_for(
      lock, kFarewell, [this]() METRONOME_REQUIRES(state_->mutex) { return state_->AllWritten(); });
  state_->closing = true;
  state_->waiting.clear();
  state_->changed.notify_all();
}

void OutputThread::Work(State& state) {
  MutexLock lock(state.mutex);
  while (true) {
    state.changed.wait(lock, [&]() METRONOME_REQUIRES(state.mutex) {
      return !state.waiting.empty() || state.closing;
    });
    if (state.waiting.empty()) return;
    const std::string text = std::move(state.waiting.front());
    state.waiting.pop_front();
    state.bytes -= text.size();
    state.writing = true;
    lock.unlock();
    WriteAll(state.descriptor, text);
    lock.lock();
    state.writing = false;
    state.stuck = false;
    state.changed.notify_all();
  }
}

void OutputThread::Write(std::string text) {
  const MutexLock lock(state_->mutex);
  state_->bytes += text.size();
  state_->waiting.push_back(std::move(text));
  while (state_->bytes > kMostWaiting) {
    state_->bytes -= state_->waiting.front().size();
    state_->waiting.pop_front();
  }
  state_->changed.notify_all();
}

bool OutputThread::Flush(std::chrono::milliseconds timeout) {
  MutexLock lock(state_->mutex);
  if (state_->stuck) return false;
  const bool written = state_->changed.wait_for(
      lock, timeout, [this]() METRONOME_REQUIRES(state_->mutex) { return state_->AllWritten(); });
  state_->stuck = !written;
  return written;
}

}  // namespace metronome::process
