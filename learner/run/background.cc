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
    const std::lock_guard lock(mutex_);
    closing_ = true;
    changed_.notify_all();
  }
  thread_.join();
}

void BackgroundThread::Start(std::function<void()> work) {
  const std::lock_guard lock(mutex_);
  if (work_) throw std::logic_error("other work still runs");
  work_ = std::move(work);
  changed_.notify_all();
}

void BackgroundThread::Wait() {
  std::unique_lock lock(mutex_);
  changed_.wait(lock, [this] { return !work_; });
}

void BackgroundThread::Loop() {
  std::unique_lock lock(mutex_);
  while (true) {
    changed_.wait(lock, [this] { return work_ || closing_; });
    if (!work_) return;
    lock.unlock();
    work_();
    lock.lock();
    work_ = nullptr;
    changed_.notify_all();
  }
}

}  // namespace metronome::run
