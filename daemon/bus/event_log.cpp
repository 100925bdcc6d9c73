// SPDX-License-Identifier: BSD-3-Clause
#include "bus/event_log.hpp"

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <stdexcept>
#include <zlib.h>

namespace slam {
namespace {

constexpr std::uint32_t kSync = 0xEDA1DA01;
constexpr std::size_t kHeader = 28;        // sync, event number, time, channel length, data length
constexpr std::size_t kMaxChannel = 63;    // LCM's limit
constexpr std::size_t kMaxData = 1 << 25;  // [bytes] LCM takes more, but no sensor sends that
constexpr std::size_t kChunk = 1 << 16;

/// How far the next record may begin behind `begin`, where none does.
std::size_t bytesToSync(const std::vector<std::uint8_t>& buffer, std::size_t begin) {
  const auto from = buffer.begin() + static_cast<std::ptrdiff_t>(begin);
  return static_cast<std::size_t>(std::find(from + 1, buffer.end(), std::uint8_t{kSync >> 24}) - from);
}

}  // namespace

EventLogReader::EventLogReader(const std::filesystem::path& file, std::uint64_t begin) {
  file_ = gzopen(file.c_str(), "rb");
  if (file_ == nullptr) throw std::runtime_error(file.string() + ": cannot open: " + std::strerror(errno));
  gzseek(static_cast<gzFile>(file_), static_cast<z_off_t>(begin), SEEK_SET);
  while (fill(4)) {
    if (bigEndian(0, 4) == kSync) return;
    const std::size_t damaged = bytesToSync(buffer_, begin_);
    begin_ += damaged;
    skipped_ += damaged;
  }
  gzclose(static_cast<gzFile>(file_));
  throw EmptyLog(file.string() + ": no LCM event in it; is it an LCM log (slam-convert makes one)?");
}

EventLogReader::~EventLogReader() { gzclose(static_cast<gzFile>(file_)); }

bool EventLogReader::fill(std::size_t bytes) {
  while (buffer_.size() - begin_ < bytes && !end_) {
    if (begin_ > kChunk) {
      buffer_.erase(buffer_.begin(), buffer_.begin() + static_cast<std::ptrdiff_t>(begin_));
      begin_ = 0;
    }
    const std::size_t size = buffer_.size();
    buffer_.resize(size + kChunk);
    const int got = gzread(static_cast<gzFile>(file_), buffer_.data() + size, kChunk);
    buffer_.resize(size + static_cast<std::size_t>(std::max(0, got)));
    end_ = got <= 0;  // a damaged gzip stream ends here, too
  }
  return buffer_.size() - begin_ >= bytes;
}

std::uint64_t EventLogReader::bigEndian(std::size_t offset, std::size_t bytes) const {
  std::uint64_t value = 0;
  for (std::size_t i = 0; i < bytes; ++i) value = value << 8 | buffer_[begin_ + offset + i];
  return value;
}

bool EventLogReader::next(LogEvent& event) {
  while (fill(kHeader)) {
    if (bigEndian(0, 4) != kSync) {
      const std::size_t damaged = bytesToSync(buffer_, begin_);
      begin_ += damaged;
      skipped_ += damaged;
      continue;
    }
    const std::uint64_t channel = bigEndian(20, 4), data = bigEndian(24, 4);
    if (channel == 0 || channel > kMaxChannel || data > kMaxData) {
      ++begin_, ++skipped_;
      continue;
    }
    const std::size_t size = kHeader + channel + data;
    if (!fill(size)) {
      // Cut off, or a damaged length that reaches past the end: whole records may still follow it.
      truncated_ = true;
      ++begin_, ++skipped_;
      continue;
    }
    const auto name = buffer_.begin() + static_cast<std::ptrdiff_t>(begin_ + kHeader);
    if (std::find(name, name + static_cast<std::ptrdiff_t>(channel), 0) !=
        name + static_cast<std::ptrdiff_t>(channel)) {
      ++begin_, ++skipped_;  // a channel is a C string: this length is damaged
      continue;
    }
    // Where no record follows the claimed end, either what follows is damaged or this length is: then the next record
    // begins inside.
    const bool at_end = !fill(size + 4) && buffer_.size() - begin_ == size;
    const bool followed = fill(size + 4) && bigEndian(size, 4) == kSync;
    if (!at_end && !followed) {
      bool inside = false;
      for (std::size_t i = 1; i < size && fill(i + 4) && !inside; ++i) inside = bigEndian(i, 4) == kSync;
      if (inside) {
        ++begin_, ++skipped_;
        continue;
      }
    }
    truncated_ = false;
    const auto at = buffer_.begin() + static_cast<std::ptrdiff_t>(begin_);
    event.utime = static_cast<std::int64_t>(bigEndian(12, 8));
    event.channel.assign(at + kHeader, at + static_cast<std::ptrdiff_t>(kHeader + channel));
    event.data.assign(at + static_cast<std::ptrdiff_t>(kHeader + channel), at + static_cast<std::ptrdiff_t>(size));
    begin_ += size;
    return true;
  }
  skipped_ += buffer_.size() - begin_;
  if (buffer_.size() > begin_) truncated_ = true;
  begin_ = buffer_.size();
  return false;
}

EventLogSequence::EventLogSequence(std::vector<std::filesystem::path> files) : files_(std::move(files)) {
  openNext();
  if (!reader_) throw EmptyLog("no log is given");
}

void EventLogSequence::openNext() {
  if (reader_) {
    skipped_ += reader_->skippedBytes();
    truncated_ |= reader_->truncated();
    reader_.reset();
  }
  while (!reader_ && at_ < files_.size()) {
    try {
      reader_ = std::make_unique<EventLogReader>(files_[at_++]);
      read_ = true;
    } catch (const EmptyLog&) {
      truncated_ = true;
      if (at_ == files_.size() && !read_) throw;
    }
  }
}

bool EventLogSequence::next(LogEvent& event) {
  while (reader_) {
    if (reader_->next(event)) return true;
    openNext();
  }
  return false;
}

std::size_t recordSize(const std::string& channel, std::span<const std::uint8_t> data) {
  return kHeader + channel.size() + data.size();
}

void appendRecord(std::string& out, std::int64_t number, std::int64_t utime, const std::string& channel,
                  std::span<const std::uint8_t> data) {
  const auto put = [&out](auto value) {  // big-endian
    for (std::size_t byte = sizeof value; byte-- > 0;) out.push_back(static_cast<char>(value >> (8 * byte) & 0xFF));
  };
  put(kSync);
  put(static_cast<std::uint64_t>(number));
  put(static_cast<std::uint64_t>(utime));
  put(static_cast<std::uint32_t>(channel.size()));
  put(static_cast<std::uint32_t>(data.size()));
  out += channel;
  out.append(reinterpret_cast<const char*>(data.data()), data.size());
}

EventLogWriter::EventLogWriter(const std::filesystem::path& file) : file_(file, std::ios::binary) {
  if (!file_) throw std::runtime_error(file.string() + ": cannot write: " + std::strerror(errno));
}

bool EventLogWriter::flush() { return file_.flush().good(); }

bool EventLogWriter::write(std::int64_t utime, const std::string& channel, std::span<const std::uint8_t> data) {
  record_.clear();
  appendRecord(record_, number_++, utime, channel, data);
  return file_.write(record_.data(), static_cast<std::streamsize>(record_.size())).good();
}

}  // namespace slam
