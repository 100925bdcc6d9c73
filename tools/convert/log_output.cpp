// SPDX-License-Identifier: BSD-3-Clause
#include "tools/convert/log_output.hpp"

#include <algorithm>
#include <stdexcept>

#include "bus/channels.hpp"
#include "bus/messages.hpp"

namespace slam {

template <typename Message>
void LogOutput::append(std::int64_t arrival, const char* channel, const Message& message) {
  Record record{arrival, channel, {}};
  record.data.resize(static_cast<std::size_t>(message.getEncodedSize()));
  message.encode(record.data.data(), 0, static_cast<int>(record.data.size()));
  records_.push_back(std::move(record));
}

void LogOutput::add(std::int64_t arrival, const LaserScan& scan, std::int64_t utime) {
  append(arrival, channel::kScan, toMessage(scan, utime));
}

void LogOutput::add(std::int64_t arrival, const WheelSample& sample, std::int64_t utime, std::vector<double> angles) {
  append(arrival, channel::kWheels, toMessage(sample, utime, angles));
}

void LogOutput::add(std::int64_t arrival, const ImuSample& sample, std::int64_t utime) {
  append(arrival, channel::kImu, toMessage(sample, utime));
}

void LogOutput::write(const std::filesystem::path& file) {
  if (records_.empty()) throw std::runtime_error(file.string() + ": not written: the input holds no sample");
  std::stable_sort(records_.begin(), records_.end(),
                   [](const Record& a, const Record& b) { return a.arrival < b.arrival; });
  EventLogWriter log(file);
  bool written = true;
  for (const Record& record : records_) written = written && log.write(record.arrival, record.channel, record.data);
  if (!written || !log.flush()) throw std::runtime_error(file.string() + ": cannot write all of it; is the disk full?");
}

}  // namespace slam
