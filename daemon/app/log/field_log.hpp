// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <atomic>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <string_view>

#include "app/log/record_sink.hpp"
#include "app/log/trouble_log.hpp"
#include "app/threads/thread_messages.hpp"
#include "config/config.hpp"
#include "runtime/clock.hpp"
#include "runtime/job_thread.hpp"
#include "runtime/shared_value.hpp"
#include "runtime/spsc_queue.hpp"
#include "store/durable_file.hpp"
#include "store/log_policy.hpp"

namespace slam {

/// A person's command about the field log.
struct LogCommand {
  enum Kind : std::uint8_t { kStart, kStop, kMark } kind = kStart;
  std::int32_t id = 0;  ///< of the message
  std::string what;     ///< of a mark
};

/// What each file of the field log begins with: what slamd runs as, and what by.
class LogHeader {
 public:
  explicit LogHeader(const Config& config);
  const std::string& bootId() const { return boot_id_; }
  /// Of the map from now on. From any thread.
  void setMap(std::int32_t map_id) { map_id_ = map_id; }
  /// @param utime [us] of the file's first message
  std::string record(std::int64_t utime) const;

 private:
  const std::string boot_id_, configuration_;
  std::atomic<std::int32_t> map_id_{0};
};

/// A thread of low priority, *log keeper*: compresses files that are closed, and removes the oldest.
class LogKeeper {
 public:
  LogKeeper(const LogConfig& config, const LogLimits& limits) : config_(config), limits_(limits) {}
  ~LogKeeper() { ending_ = true; }
  bool isBusy() const { return thread_.isBusy(); }
  /// @param run the present one @param end number behind those of the closed files
  void start(const std::filesystem::path& run, std::int64_t end) {
    thread_.start([this, run, end] { keep(run, end); });
  }
  /// Whether the disk keeps the thread: then it cannot be joined.
  bool hangs(Timestamp deadline);

 private:
  void keep(const std::filesystem::path& run, std::int64_t end);

  const LogConfig& config_;
  const LogLimits& limits_;
  bool lowered_ = false;  // the thread's priority
  TroubleLog log_;
  std::atomic<bool> ending_{false};
  JobThread thread_{"log keeper"};
};

/// The field log: a folder for each run, in files that are never overwritten and that begin with the configuration.
class FieldLog final : public RecordSink {
 public:
  /// @param wake is called when there are answers()
  FieldLog(const Config& config, const WallClock& clock, std::function<void()> wake);

  /// Whether messages of a channel are wanted now. From any thread, as all down to write().
  bool takes(std::string_view channel) const;
  bool isRunning() const { return running_; }
  /// Of the map that SLAM_CONFIG names from now on.
  void setMap(std::int32_t map_id) { header_.setMap(map_id); }
  /// For the one thread that takes commands. @return false when there are too many at once; else one of answers() comes
  bool command(const LogCommand& command) { return commands_.asked.tryPush(command); }
  SpscQueue<MapAnswer>& answers() { return commands_.answers; }
  /// Where the camera's images belong now; empty: nowhere.
  std::string imagesPath() const { return images_.get(); }
  /// See LogKeeper::hangs().
  bool keeperHangs(Timestamp deadline) { return keeper_.hangs(deadline); }

  void tend() override;
  void write(std::string_view records, std::int64_t utime) override;
  void finish() override;
  Problem problemOf(const std::exception& error) const override;

 private:
  void obey(const LogCommand& command);
  std::string mark(const std::string& what);
  void prepare(Timestamp now);
  void checkRoom(Timestamp now);
  void begin(std::string_view records, std::int64_t utime, Timestamp now);
  void close();
  void drop();

  const LogConfig config_;
  const LogLimits limits_;
  const WallClock& clock_;
  LogHeader header_;
  struct {
    SpscQueue<LogCommand> asked{8};
    SpscQueue<MapAnswer> answers{8};
    std::function<void()> wake;
  } commands_;
  std::atomic<bool> running_;
  SharedValue<std::string> images_;
  // Of the recorder's thread:
  std::optional<FolderLock> lock_;
  std::filesystem::path run_;  // empty: not made yet
  struct Open {
    Open(const std::filesystem::path& path, Timestamp now) : file(path, AppendFile::kNew), begun(now), synced(now) {}
    AppendFile file;
    Timestamp begun, synced;
    std::uint64_t synced_size = 0, image_bytes = 0;  // [bytes]
  };
  std::optional<Open> open_;
  std::int64_t number_ = -1;  // of the open file, or of the last one in the folder
  Problem why_not_;           // nothing could be written the last time
  bool short_logged_ = false;
  struct Room {
    Timestamp looked;
    std::uint64_t free = 0;  // [bytes]
    bool enough = true;
  } room_;
  LogKeeper keeper_;
};

}  // namespace slam
