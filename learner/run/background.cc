#include "learner/run/background.h"

#include <pthread.h>

#include <stdexcept>
#include <utility>

namespace metronome::run {

BackgroundThread::BackgroundThread(const std::string& name) : thread_([this] { Loop(); }) {
  pthread_setname_np(thread_.native_handle(), name.substr(0, 15).c_str());
}

BackgroundThread::~BackgroundThread() {
  {
    const process::MutexLock lock(mutex_);
    closing_ = true;
    changed_.notify_all();
  }
  thread_.join();
}

void BackgroundThread::Start(std::function<void()> work) {
  const process::MutexLock lock(mutex_);
  if (work_ || runs_) throw std::logic_error("other work still runs");
  work_ = std::move(work);
  changed_.notify_all();
}

void BackgroundThread::Wait() {
  process::MutexLock lock(mutex_);
  changed_.wait(lock, [this]() METRONOME_REQUIRES(mutex_) { return !work_ && !runs_; });
}

void BackgroundThread::Loop() {
  process::MutexLock lock(mutex_);
  while (true) {
    changed_.wait(lock, [this]() METRONOME_REQUIRES(mutex_) { return work_ || closing_; });
    if (!work_) return;
    std::function<void()> work = std::exchange(work_, nullptr);
    runs_ = true;
    lock.unlock();
    work();
    work = nullptr;
    lock.lock();
    runs_ = false;
    changed_.notify_all();
  }
}

}  // namespace metronome::run
