// SPDX-License-Identifier: BSD-3-Clause
#include "tools/convert/log_output.hpp"

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <queue>
#include <stdexcept>
#include <unistd.h>
#include <utility>

#include "bus/channels.hpp"
#include "bus/messages.hpp"
#include "core/plausibility.hpp"

namespace slam {

template <typename Message>
void LogOutput::append(std::int64_t arrival, const char* channel, const Message& message) {
  message_.resize(static_cast<std::size_t>(message.getEncodedSize()));
  message.encode(message_.data(), 0, static_cast<int>(message_.size()));
  add(arrival, channel, message_);
}

void LogOutput::add(std::int64_t arrival, const LaserScan& scan, std::int64_t utime) {
  append(arrival, channel::kScan, toMessage(scan, utime));
}

void LogOutput::add(std::int64_t arrival, const WheelSample& sample, std::int64_t utime,
                    std::span<const double> angles) {
  if (!isPlausible(sample)) return void(++implausible_wheels_);
  append(arrival, channel::kWheels, toMessage(sample, utime, angles));
}

void LogOutput::add(std::int64_t arrival, const ImuSample& sample, std::int64_t utime) {
  if (!isPlausible(sample)) return void(++implausible_imu_);
  append(arrival, channel::kImu, toMessage(sample, utime));
}

void LogOutput::add(std::int64_t arrival, const char* channel, std::span<const std::uint8_t> message) {
  if (data_.size() + message.size() + records_.size() * sizeof(Record) > memory_) spill();
  records_.push_back(
      {arrival, channel, static_cast<std::uint32_t>(data_.size()), static_cast<std::uint32_t>(message.size())});
  data_.insert(data_.end(), message.begin(), message.end());
}

void LogOutput::sort() {
  std::stable_sort(records_.begin(), records_.end(),
                   [](const Record& a, const Record& b) { return a.arrival < b.arrival; });
}

void LogOutput::spill() {
  if (records_.empty()) return;
  sort();
  if (!spilled_) spilled_.reset(std::tmpfile());
  const std::uint64_t begin = parts_.empty() ? 0 : parts_.back().end;
  std::uint64_t end = begin;
  bool written = spilled_ != nullptr;
  for (const Record& record : records_) {
    written = written && std::fwrite(&record, sizeof(record), 1, spilled_.get()) == 1 &&
              std::fwrite(data_.data() + record.begin, 1, record.size, spilled_.get()) == record.size;
    end += sizeof(record) + record.size;
  }
  if (!written || std::fflush(spilled_.get()) != 0) {
    throw std::runtime_error(std::string("cannot write a temporary file: ") + std::strerror(errno));
  }
  parts_.push_back({begin, end});
  records_.clear();
  data_.clear();
}

/// Reads a sorted part again, record by record.
class LogOutput::PartReader {
 public:
  PartReader(int file, const Part& part) : file_(file), at_(part.begin), end_(part.end) { next(); }

  bool done() const { return done_; }
  std::int64_t arrival() const { return record_.arrival; }
  const char* channel() const { return record_.channel; }
  std::span<const std::uint8_t> message() { return take(record_.size); }
  void next() {
    done_ = buffer_.size() == taken_ && at_ == end_;
    if (!done_) std::memcpy(&record_, take(sizeof(record_)).data(), sizeof(record_));
  }

 private:
  std::span<const std::uint8_t> take(std::size_t bytes) {
    constexpr std::size_t kStep = std::size_t{1} << 15;  // [bytes] that are read at once
    if (buffer_.size() - taken_ < bytes) {
      buffer_.erase(buffer_.begin(), buffer_.begin() + static_cast<std::ptrdiff_t>(taken_));
      taken_ = 0;
      const std::size_t begin = buffer_.size();
      buffer_.resize(begin + std::min<std::uint64_t>(std::max(kStep, bytes - begin), end_ - at_));
      const auto wanted = static_cast<ssize_t>(buffer_.size() - begin);
      if (buffer_.size() < bytes ||
          ::pread(file_, buffer_.data() + begin, static_cast<std::size_t>(wanted), static_cast<off_t>(at_)) != wanted) {
        throw std::runtime_error("cannot read the temporary file again");
      }
      at_ += static_cast<std::uint64_t>(wanted);
    }
    taken_ += bytes;
    return {buffer_.data() + (taken_ - bytes), bytes};
  }

  int file_;
  std::uint64_t at_, end_;  // in the file
  std::vector<std::uint8_t> buffer_;
  std::size_t taken_ = 0;  // of the buffer
  Record record_{};
  bool done_ = false;
};

void LogOutput::write(const std::filesystem::path& file, Recording* recording) {
  if (recording != nullptr) {
    recording->wheels -= implausible_wheels_;
    recording->imu -= implausible_imu_;
    for (int i = 0; i < implausible_wheels_ + implausible_imu_; ++i)
      recording->reject("wheels or IMU", "a number is beyond all that can be measured");
  }
  if (records_.empty() && parts_.empty()) {
    throw std::runtime_error(file.string() + ": not written: the input holds no sample");
  }
  bool written = true;
  EventLogWriter log(file);
  if (parts_.empty()) {
    sort();
    for (const Record& record : records_)
      written = written && log.write(record.arrival, record.channel, {data_.data() + record.begin, record.size});
  } else {
    spill();
    std::vector<PartReader> parts;
    for (const Part& part : parts_) parts.emplace_back(::fileno(spilled_.get()), part);
    // The part with the earliest record, of equal ones the first.
    const auto later = [&](std::size_t a, std::size_t b) {
      return std::pair(parts[a].arrival(), a) > std::pair(parts[b].arrival(), b);
    };
    std::priority_queue<std::size_t, std::vector<std::size_t>, decltype(later)> waiting(later);
    for (std::size_t i = 0; i < parts.size(); ++i) waiting.push(i);
    while (!waiting.empty() && written) {
      const std::size_t first = waiting.top();
      waiting.pop();
      PartReader& part = parts[first];
      const std::int64_t arrival = part.arrival();
      const char* channel = part.channel();
      written = log.write(arrival, channel, part.message());
      part.next();
      if (!part.done()) waiting.push(first);
    }
  }
  if (!written || !log.flush()) throw std::runtime_error(file.string() + ": cannot write all of it; is the disk full?");
}

}  // namespace slam
