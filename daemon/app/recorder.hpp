// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <atomic>
#include <condition_variable>
#include <cstdint>
#include <filesystem>
#include <mutex>
#include <optional>
#include <span>
#include <string>

#include "app/storage_report.hpp"
#include "drivers/retry.hpp"
#include "runtime/shared_text.hpp"
#include "runtime/worker.hpp"
#include "store/durable_file.hpp"

namespace slam {

/// Thread *record*: writes what is published into an LCM event log. Who publishes never waits for the disk: what the
/// disk does not take in time is dropped and counted. A file that cannot be written, or was removed, is opened again.
class Recorder {
 public:
  static constexpr std::size_t kCapacity = 8 << 20;  // [bytes] about twenty seconds of all channels

  /// Begins the file anew. @throws std::system_error when the thread cannot be made
  explicit Recorder(std::filesystem::path file, std::size_t capacity = kCapacity);
  ~Recorder() { worker_.stop(); }

  /// @param utime [us] of the log
  void add(std::int64_t utime, const std::string& channel, std::span<const std::uint8_t> data);
  /// Writes what is left and ends the thread. @return false when the disk has not taken all of it by the deadline
  bool finish(Timestamp deadline);

  std::uint64_t written() const { return written_; }  ///< messages
  std::uint64_t dropped() const { return dropped_; }
  StorageReport report(Timestamp now) const;

 private:
  void tick();
  void write();

  const std::filesystem::path path_;
  const std::size_t capacity_;  // [bytes] of pending_
  std::mutex mutex_;
  std::condition_variable changed_;
  std::string pending_;                 // records, not yet taken by the thread
  std::uint64_t pending_messages_ = 0;  // in it
  std::int64_t number_ = 0;             // of the next record
  bool ending_ = false, ended_ = false;
  std::atomic<std::uint64_t> written_{0}, dropped_{0};
  std::atomic<std::int64_t> waits_since_ns_{0};  // for the disk; 0: it does not
  SharedText problem_;
  // Of the thread:
  std::string block_;  // being written
  std::uint64_t block_messages_ = 0;
  std::optional<AppendFile> file_;
  bool begun_ = false, failing_ = false;  // failing: logged
  Retry retry_{std::chrono::milliseconds(500), std::chrono::seconds(5)};
  Worker worker_;
};

}  // namespace slam
