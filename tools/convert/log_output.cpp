// SPDX-License-Identifier: BSD-3-Clause
#include "tools/convert/log_output.hpp"

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <stdexcept>

#include "bus/channels.hpp"
#include "bus/messages.hpp"

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
  append(arrival, channel::kWheels, toMessage(sample, utime, angles));
}

void LogOutput::add(std::int64_t arrival, const ImuSample& sample, std::int64_t utime) {
  append(arrival, channel::kImu, toMessage(sample, utime));
}

void LogOutput::add(std::int64_t arrival, const char* channel, std::span<const std::uint8_t> message) {
  if (data_.size() + message.size() > memory_) spill();
  records_.push_back({arrival, channel, spilled_bytes_ + data_.size(), static_cast<std::uint32_t>(message.size())});
  data_.insert(data_.end(), message.begin(), message.end());
}

void LogOutput::spill() {
  if (data_.empty()) return;
  if (!spilled_) spilled_.reset(std::tmpfile());
  if (!spilled_ || std::fwrite(data_.data(), 1, data_.size(), spilled_.get()) != data_.size()) {
    throw std::runtime_error(std::string("cannot write a temporary file: ") + std::strerror(errno));
  }
  spilled_bytes_ += data_.size();
  data_.clear();
}

void LogOutput::write(const std::filesystem::path& file) {
  if (records_.empty()) throw std::runtime_error(file.string() + ": not written: the input holds no sample");
  std::stable_sort(records_.begin(), records_.end(),
                   [](const Record& a, const Record& b) { return a.arrival < b.arrival; });
  if (spilled_) std::fflush(spilled_.get());
  EventLogWriter log(file);
  bool written = true;
  for (const Record& record : records_) {
    std::span<const std::uint8_t> message;
    if (record.begin >= spilled_bytes_) {
      message = {data_.data() + (record.begin - spilled_bytes_), record.size};
    } else {
      message_.resize(record.size);
      if (::fseeko(spilled_.get(), static_cast<off_t>(record.begin), SEEK_SET) != 0 ||
          std::fread(message_.data(), 1, record.size, spilled_.get()) != record.size) {
        throw std::runtime_error("cannot read the temporary file again");
      }
      message = message_;
    }
    written = written && log.write(record.arrival, record.channel, message);
  }
  if (!written || !log.flush()) throw std::runtime_error(file.string() + ": cannot write all of it; is the disk full?");
}

}  // namespace slam
