// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <atomic>
#include <cstdint>
#include <memory>
#include <mutex>
#include <span>
#include <string>

#include "app/log/record_sink.hpp"
#include "app/log/storage_report.hpp"
#include "core/counter_info.hpp"
#include "drivers/retry.hpp"
#include "runtime/shared_value.hpp"
#include "runtime/thread_use.hpp"
#include "runtime/worker.hpp"

namespace slam {

/// What a Recorder counts.
struct RecorderCounters {
  std::atomic<std::uint64_t> written{0}, dropped{0};

  template <typename Visitor>
  friend void visitCounters(const RecorderCounters& c, const std::string& name, Visitor&& visit) {
    visit(CounterInfo{name + ".written", "messages", "Messages that the disk has taken."}, c.written);
    visit(CounterInfo{name + ".dropped", "messages", "Messages that the disk did not take in time."}, c.dropped);
  }
};

/// A thread that writes messages as records of an LCM event log. Who hands them over never waits for the disk: what the
/// disk does not take in time is dropped and counted. What cannot be written is tried again.
class Recorder {
 public:
  static constexpr std::size_t kCapacity = 8 << 20;  // [bytes] about twenty seconds of all channels

  /// @param name of the thread @throws std::system_error when the thread cannot be made
  Recorder(std::string name, std::unique_ptr<RecordSink> sink, std::size_t capacity = kCapacity);
  ~Recorder() { worker_.stop(); }

  /// @param utime [us] of the log
  void add(std::int64_t utime, const std::string& channel, std::span<const std::uint8_t> data);
  /// Writes what is left and ends the thread. @return false when the disk has not taken all of it by the deadline
  bool finish(Timestamp deadline);

  const std::string& name() const { return worker_.name(); }
  const RecorderCounters& counters() const { return counters_; }
  StorageReport report(Timestamp now) const;

 private:
  struct Block {
    std::string records;
    std::uint64_t messages = 0;
    std::int64_t utime = 0;  // [us] of the first one
  };

  void tick();

  const std::unique_ptr<RecordSink> sink_;
  const std::size_t capacity_;  // [bytes] of pending_
  std::mutex mutex_;
  Block pending_;            // not yet taken by the thread
  std::int64_t number_ = 0;  // of the next record
  bool ending_ = false;
  EndSignal end_;
  RecorderCounters counters_;
  BlockedTime waits_;                      // for the disk
  std::atomic<std::uint64_t> starved_{0};  // of those dropped: this thread had too little of the CPU to take them
  SharedValue<Problem> problem_;
  std::atomic<bool> failing_{false};  // at the last attempt
  // Of the thread:
  Block block_;  // being written
  Retry retry_{std::chrono::milliseconds(500), std::chrono::seconds(5)};
  Worker worker_;
};

}  // namespace slam
