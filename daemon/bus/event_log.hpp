// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <memory>
#include <span>
#include <stdexcept>
#include <string>
#include <vector>

namespace slam {

/// One record of an LCM event log.
struct LogEvent {
  std::int64_t utime = 0;  ///< [µs since the epoch] when it was logged
  std::string channel;
  std::vector<std::uint8_t> data;
};

/// A log without a single record, as a power cut may leave it.
struct EmptyLog : std::runtime_error {
  using std::runtime_error::runtime_error;
};

/// Reads an LCM event log, plain or gzip-compressed.
///
/// liblcm's own reader ends at the first damaged record; this one looks for the next sync word (EDA1DA01), counts what
/// it had to skip, and bounds every length, so that a cut or corrupted log gives all that is whole in it.
class EventLogReader {
 public:
  /// @param begin [bytes] of the file, unpacked, that are passed over
  /// @throws EmptyLog when the file holds no record at all behind that
  /// @throws std::runtime_error when it cannot be opened
  explicit EventLogReader(const std::filesystem::path& file, std::uint64_t begin = 0);
  ~EventLogReader();
  EventLogReader(const EventLogReader&) = delete;
  EventLogReader& operator=(const EventLogReader&) = delete;

  /// @return false at the end of the log
  bool next(LogEvent& event);

  std::uint64_t skippedBytes() const { return skipped_; }  ///< bytes that belong to no record
  bool truncated() const { return truncated_; }            ///< the last record was cut off

 private:
  bool fill(std::size_t bytes);
  std::uint64_t bigEndian(std::size_t offset, std::size_t bytes) const;

  void* file_ = nullptr;  // gzFile
  std::vector<std::uint8_t> buffer_;
  std::size_t begin_ = 0;
  bool end_ = false;
  std::uint64_t skipped_ = 0;
  bool truncated_ = false;
};

/// Reads logs one behind the other. One without a record is passed over, unless all are.
class EventLogSequence {
 public:
  /// @throws std::runtime_error when a file cannot be opened, or none holds a record
  explicit EventLogSequence(std::vector<std::filesystem::path> files);

  /// @return false at the end of the last one @throws std::runtime_error when a file is gone meanwhile
  bool next(LogEvent& event);

  std::uint64_t skippedBytes() const { return skipped_ + (reader_ ? reader_->skippedBytes() : 0); }
  bool truncated() const { return truncated_ || (reader_ && reader_->truncated()); }  ///< the last record of any

 private:
  void openNext();

  std::vector<std::filesystem::path> files_;
  std::size_t at_ = 0;                      // of the next one to open
  std::unique_ptr<EventLogReader> reader_;  // nullptr: behind the last one
  std::uint64_t skipped_ = 0;
  bool read_ = false, truncated_ = false;  // any
};

/// Appends one record of an LCM event log to `out`. @param number of the record, counting from 0 @param utime [us]
void appendRecord(std::string& out, std::int64_t number, std::int64_t utime, const std::string& channel,
                  std::span<const std::uint8_t> data);
/// [bytes] that appendRecord() appends
std::size_t recordSize(const std::string& channel, std::span<const std::uint8_t> data);

/// Writes an LCM event log that lcm-logplayer reads.
class EventLogWriter {
 public:
  /// @throws std::runtime_error when the file cannot be opened for writing
  explicit EventLogWriter(const std::filesystem::path& file);

  /// @return false when something written so far is lost (disk full)
  bool flush();
  /// @return false when the record could not be written (disk full)
  bool write(std::int64_t utime, const std::string& channel, std::span<const std::uint8_t> data);
  template <typename Message>
  bool writeMessage(std::int64_t utime, const std::string& channel, const Message& message) {
    buffer_.resize(static_cast<std::size_t>(message.getEncodedSize()));
    message.encode(buffer_.data(), 0, static_cast<int>(buffer_.size()));
    return write(utime, channel, buffer_);
  }

 private:
  std::ofstream file_;
  std::int64_t number_ = 0;
  std::string record_;
  std::vector<std::uint8_t> buffer_;
};

}  // namespace slam
