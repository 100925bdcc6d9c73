// SPDX-License-Identifier: BSD-3-Clause
#include "runtime/job_thread.hpp"

#include <utility>

#include "runtime/clock.hpp"

namespace slam {

JobThread::JobThread(const std::string& name) : worker_({.name = name}, [this] { work(); }) { worker_.start(); }

JobThread::~JobThread() {
  {
    std::unique_lock lock(mutex_);
    changed_.wait(lock, [this] { return jobs_.empty(); });
    ending_ = true;
  }
  changed_.notify_all();
  worker_.stop();
}

void JobThread::start(std::function<void()> job) {
  {
    const std::scoped_lock lock(mutex_);
    jobs_.push_back(std::move(job));
  }
  changed_.notify_all();
}

bool JobThread::isBusy() const {
  const std::scoped_lock lock(mutex_);
  return !jobs_.empty();
}

bool JobThread::waitUntilIdle(Timestamp deadline) const {
  std::unique_lock lock(mutex_);
  return changed_.wait_for(lock, deadline - monotonicNow(), [this] { return jobs_.empty(); });
}

void JobThread::work() {
  std::unique_lock lock(mutex_);
  changed_.wait(lock, [this] { return !jobs_.empty() || ending_; });
  if (jobs_.empty()) return worker_.requestStop();
  const std::function<void()> job = std::move(jobs_.front());
  lock.unlock();
  blocked_.begin(monotonicNow());
  job();
  blocked_.end();
  lock.lock();
  jobs_.pop_front();
  lock.unlock();
  changed_.notify_all();
}

}  // namespace slam
