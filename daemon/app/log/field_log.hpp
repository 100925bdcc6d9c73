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

/// The field log: a folder for each run, in files that are never overwritten and that begin with the configuration.
/// A thread of low priority, *log keeper*, compresses what is closed and removes the oldest.
class FieldLog final : public RecordSink {
 public:
  /// @param wake is called when there are answers()
  FieldLog(const Config& config, const WallClock& clock, std::function<void()> wake);
  ~FieldLog() override;

  /// Whether messages of a channel are wanted now. From any thread, as all down to write().
  bool takes(std::string_view channel) const;
  bool isRunning() const { return running_; }
  /// Of the map that SLAM_CONFIG names from now on.
  void setMap(std::int32_t map_id) { map_id_ = map_id; }
  /// For the one thread that takes commands. @return false when there are too many at once; else one of answers() comes
  bool command(const LogCommand& command) { return commands_.tryPush(command); }
  SpscQueue<MapAnswer>& answers() { return answers_; }
  /// Where the camera's images belong now; empty: nowhere.
  std::string imagesPath() const { return images_.get(); }
  /// Whether the disk keeps the keeper's thread: then it cannot be joined.
  bool keeperHangs(Timestamp deadline);

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
  std::string header(std::int64_t utime) const;
  /// @param run the present one @param end number behind those of the closed files
  void keep(const std::filesystem::path& run, std::int64_t end);

  const LogConfig config_;
  const LogLimits limits_;
  const WallClock& clock_;
  const std::function<void()> wake_;
  const std::string boot_id_, configuration_;
  SpscQueue<LogCommand> commands_{8};
  SpscQueue<MapAnswer> answers_{8};
  std::atomic<bool> running_;
  std::atomic<std::int32_t> map_id_{0};
  SharedValue<std::string> images_;
  // Of the recorder's thread:
  std::optional<FolderLock> lock_;
  std::filesystem::path run_;  // empty: not made yet
  std::optional<AppendFile> file_;
  Problem why_not_;           // nothing could be written the last time
  std::int64_t number_ = -1;  // of file_, or of the last one in the folder
  Timestamp begun_{}, synced_{}, looked_{};
  std::uint64_t synced_size_ = 0;  // [bytes]
  bool has_room_ = true, short_logged_ = false;
  std::uint64_t free_ = 0, image_bytes_ = 0;  // [bytes] then
  // Of the keeper's:
  bool lowered_ = false;  // its priority
  TroubleLog keeper_log_;
  std::atomic<bool> ending_{false};
  JobThread keeper_{"log keeper"};
};

}  // namespace slam
