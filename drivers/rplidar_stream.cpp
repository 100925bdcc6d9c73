// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/rplidar_codec.hpp"

namespace slam::rplidar {

StreamDecoder::StreamDecoder(AnswerType type, double sample_time, double byte_time)
    : type_(type), sample_time_(sample_time), byte_time_(byte_time) {
  buffer_.reserve(4 * kExpressCapsuleSize);
}

void StreamDecoder::reset() {
  buffer_.clear();
  aligned_ = false;
  held_.reset();
  first_capsule_ = true;
}

void StreamDecoder::drop(std::size_t bytes) {
  buffer_.erase(buffer_.begin(), buffer_.begin() + static_cast<std::ptrdiff_t>(bytes));
}

void StreamDecoder::push(std::uint8_t byte, std::vector<TimedNode>& nodes) {
  buffer_.push_back(byte);
  type_ == AnswerType::kExpressCapsules ? pushExpress(nodes) : pushStandard(nodes);
}

void StreamDecoder::pushStandard(std::vector<TimedNode>& nodes) {
  const auto nodeAt = [this](std::size_t i) {
    return parseStandardNode({buffer_.data() + i * kStandardNodeSize, kStandardNodeSize});
  };
  const auto emit = [&](const Node& node, std::size_t bytes_after) {
    // Sampling ended half a sample before the node was sent, after one sample in the unit's filter (vendor's SDK).
    const double age = 1.5 * sample_time_ + static_cast<double>(kStandardNodeSize + bytes_after) * byte_time_;
    nodes.push_back({node, age});
    ++counters_.nodes;
  };
  if (aligned_) {
    if (buffer_.size() < kStandardNodeSize) return;
    if (const auto node = nodeAt(0)) {
      emit(*node, 0);
      drop(kStandardNodeSize);
      return;
    }
    ++counters_.bad_check_bits;
    aligned_ = false;
  }
  constexpr std::size_t kWindow = kAlignNodes * kStandardNodeSize;
  while (buffer_.size() >= kWindow) {
    bool good = true;
    for (std::size_t i = 0; i < kAlignNodes && good; ++i) good = nodeAt(i).has_value();
    if (!good) {
      drop(1);
      ++counters_.skipped_bytes;
      continue;
    }
    aligned_ = true;
    for (std::size_t i = 0; i < kAlignNodes; ++i) emit(*nodeAt(i), kWindow - (i + 1) * kStandardNodeSize);
    drop(kWindow);
  }
}

void StreamDecoder::pushExpress(std::vector<TimedNode>& nodes) {
  while (buffer_.size() >= kExpressCapsuleSize) {
    const auto capsule = parseExpressCapsule({buffer_.data(), kExpressCapsuleSize});
    if (!capsule) {
      const bool synchronous = (buffer_[0] & 0xF0) == 0xA0 && (buffer_[1] & 0xF0) == 0x50;
      if (synchronous) ++counters_.bad_checksums;
      held_.reset();
      drop(1);
      ++counters_.skipped_bytes;
      continue;
    }
    drop(kExpressCapsuleSize);
    if (capsule->start && !first_capsule_) {
      ++counters_.encoder_resets;
      held_.reset();
    }
    first_capsule_ = false;
    if (held_) {
      const auto decoded = decodeExpress(*held_, capsule->start_angle_q6);
      for (int k = 0; k < kExpressSamples; ++k) {
        // Age at the arrival of the capsule after the one that holds the sample.
        const double age = sample_time_ * (1.5 + kExpressSamples + (kExpressSamples - 1 - k)) +
                           static_cast<double>(kExpressCapsuleSize) * byte_time_;
        nodes.push_back({decoded[static_cast<std::size_t>(k)], age});
      }
      counters_.nodes += kExpressSamples;
    }
    held_ = capsule;
  }
}

}  // namespace slam::rplidar
