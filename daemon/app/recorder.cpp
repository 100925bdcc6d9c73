// SPDX-License-Identifier: BSD-3-Clause
#include "app/recorder.hpp"

#include <utility>

#include "app/log.hpp"
#include "bus/event_log.hpp"
#include "runtime/clock.hpp"

namespace slam {
namespace {

constexpr double kRate = 10.0;  // [Hz] so much is lost when the power is cut

}  // namespace

Recorder::Recorder(std::filesystem::path file, std::size_t capacity)
    : path_(std::move(file)), capacity_(capacity), worker_({.name = "record", .rate = kRate}, [this] { tick(); }) {
  worker_.start();
}

void Recorder::add(std::int64_t utime, const std::string& channel, std::span<const std::uint8_t> data) {
  const std::scoped_lock lock(mutex_);
  if (ending_ || pending_.size() + recordSize(channel, data) > capacity_) {
    ++dropped_;
    return;
  }
  appendRecord(pending_, number_++, utime, channel, data);
  ++pending_messages_;
}

void Recorder::tick() {
  bool last = false;
  {
    const std::scoped_lock lock(mutex_);
    last = ending_;
    if (block_.empty()) {
      std::swap(block_, pending_);
      block_messages_ = std::exchange(pending_messages_, 0);
    }
  }
  const Timestamp now = monotonicNow();
  if (last || retry_.due(now)) {
    waits_since_ns_ = now.time_since_epoch().count();
    try {
      write();
      retry_.succeeded();
      problem_.set("");
      if (std::exchange(failing_, false)) logInfo("the record " + path_.string() + " is written again");
    } catch (const std::exception& error) {
      file_.reset();
      retry_.failed(now);
      const std::string problem = std::string(error.what()) +
                                  "; the record is not written, slamd goes on without and tries again; make room or "
                                  "the folder for it, or change output.record";
      problem_.set(problem);
      if (!std::exchange(failing_, true)) logError(problem);
    }
    waits_since_ns_ = 0;
  }
  if (!last) return;
  const std::scoped_lock lock(mutex_);
  if (!failing_ && !pending_.empty()) return;  // once more
  dropped_ += block_messages_ + pending_messages_;
  ended_ = true;
  worker_.requestStop();
  changed_.notify_all();
}

void Recorder::write() {
  if (file_ && !file_->isThere()) file_.reset();
  if (!file_) {
    if (path_.has_parent_path()) std::filesystem::create_directories(path_.parent_path());
    file_.emplace(path_, begun_ ? AppendFile::kAll : 0);
    begun_ = true;
  }
  if (block_.empty()) return;
  file_->append(block_);
  block_.clear();
  written_ += std::exchange(block_messages_, 0);
}

bool Recorder::finish(Timestamp deadline) {
  {
    std::unique_lock lock(mutex_);
    ending_ = true;
    if (!changed_.wait_for(lock, deadline - monotonicNow(), [this] { return ended_; })) return false;
  }
  worker_.stop();
  return problem_.get().empty();
}

StorageReport Recorder::report(Timestamp now) const {
  const std::int64_t since = waits_since_ns_;
  StorageReport report{problem_.get(), since == 0 ? Duration(0) : now - Timestamp(Duration(since))};
  if (dropped_ > 0) {
    report.problem += (report.problem.empty() ? "" : "; ") + std::to_string(dropped_) +
                      " messages are missing in it: the disk was away or too slow";
  }
  return report;
}

}  // namespace slam
