// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/lidar/lidar_scan_stream.hpp"

#include <utility>

namespace slam {

LidarScanStream::LidarScanStream(std::unique_ptr<LidarDecoder> decoder, const Format& format)
    : format_(format),
      decoder_(std::move(decoder)),
      clock_(format.sample_time),
      assembler_(format.limits),
      boot_text_(format.boot_text) {
  nodes_.reserve(decoder_->mostNodes());
}

int LidarScanStream::push(std::span<const std::uint8_t> bytes, Timestamp arrival, const Sink& sink) {
  int count = 0;
  for (std::size_t i = 0; i < bytes.size(); ++i) {
    saw_boot_text_ = boot_text_.push(bytes[i]) || saw_boot_text_;
    nodes_.clear();
    decoder_->push(bytes[i], nodes_);
    if (nodes_.empty()) continue;
    if (const auto shifts = decoder_->zeroShifts(); shifts != zero_shifts_) {
      zero_shifts_ = shifts;
      assembler_.reset();  // its angles count from another zero
    }
    const Timestamp byte_arrival = arrival - fromSeconds(format_.byte_time * static_cast<double>(bytes.size() - 1 - i));
    int lost = decoder_->lost();
    for (const TimedNode& timed : nodes_) {
      const Timestamp stamp = clock_.stamp(byte_arrival - fromSeconds(timed.age), std::exchange(lost, 0));
      if (const LaserScan* scan = assembler_.add(timed.node, stamp)) sink(*scan);
    }
    if (decoder_->endsTurn()) {
      if (const LaserScan* scan = assembler_.endTurn()) sink(*scan);
    }
    count += static_cast<int>(nodes_.size());
  }
  return count;
}

void LidarScanStream::skip(std::span<const std::uint8_t> bytes) {
  for (const std::uint8_t byte : bytes) saw_boot_text_ = boot_text_.push(byte) || saw_boot_text_;
}

void LidarScanStream::restart() {
  decoder_->reset();
  assembler_.reset();
  clock_ = SampleClock(format_.sample_time);
  ++restarts_;
}

std::int64_t LidarScanStream::rejects() const {
  return decoder_->rejects() + decoder_->zeroShifts() + restarts_ + assembler_.broken();
}

}  // namespace slam
