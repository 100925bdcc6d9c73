// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/lidar/rplidar_stream.hpp"

#include <algorithm>
#include <utility>

namespace slam::rplidar {
namespace {

constexpr int kHalfTurnQ6 = 180 * 64;
constexpr std::size_t kWindow = StreamDecoder::kAlignNodes * kStandardNodeSize;

}  // namespace

std::optional<PacketFormat> packetFormat(std::uint8_t type) {
  switch (static_cast<AnswerType>(type)) {
    case AnswerType::kStandardNodes:
      return PacketFormat{kStandardNodeSize, 1};
    case AnswerType::kExpressCapsules:
      return PacketFormat{kExpressCapsuleSize, kExpressSamples};
    case AnswerType::kUltraCapsules:
      return PacketFormat{kUltraCapsuleSize, kUltraSamples};
    case AnswerType::kDenseCapsules:
      return PacketFormat{kDenseCapsuleSize, kDenseSamples};
    case AnswerType::kUltraDenseCapsules:
      return PacketFormat{kUltraDenseCapsuleSize, kUltraDenseSamples, kUltraDenseAngleAt};
    default:
      return std::nullopt;
  }
}

StreamDecoder::StreamDecoder(AnswerType type, double sample_time, double byte_time)
    : type_(type),
      format_(packetFormat(static_cast<std::uint8_t>(type)).value_or(PacketFormat{kStandardNodeSize, 1})),
      sample_time_(sample_time),
      byte_time_(byte_time) {
  buffer_.reserve(2 * kLongestPacket);
}

void StreamDecoder::reset() {
  buffer_begin_ += buffer_.size();
  buffer_.clear();
  next_expected_.reset();
  aligned_ = false;
  held_head_.reset();
  first_capsule_ = true;
  width_q6_ = 0;
}

void StreamDecoder::drop(std::size_t bytes) {
  buffer_.erase(buffer_.begin(), buffer_.begin() + static_cast<std::ptrdiff_t>(bytes));
  buffer_begin_ += bytes;
}

/// The unit samples and sends on while a receiver skips bytes: each skipped packet is its samples lost.
void StreamDecoder::countLost(std::uint64_t packet_begin) {
  const std::uint64_t skipped = packet_begin - next_expected_.value_or(packet_begin);
  next_expected_ = packet_begin + format_.size;
  lost_ += static_cast<int>((skipped + format_.size / 2) / format_.size) * format_.samples;
}

void StreamDecoder::push(std::uint8_t byte, std::vector<TimedNode>& nodes) {
  lost_ = 0;
  buffer_.push_back(byte);
  type_ == AnswerType::kStandardNodes ? pushStandard(nodes) : pushCapsule(nodes);
}

void StreamDecoder::pushStandard(std::vector<TimedNode>& nodes) {
  const auto nodeAt = [this](std::size_t i) {
    return parseStandardNode({buffer_.data() + i * kStandardNodeSize, kStandardNodeSize});
  };
  const auto take = [&](const Node& node, std::size_t bytes_after) {
    // Sampling ended half a sample before the node was sent, after one sample in the unit's filter (vendor's SDK).
    const double age = 1.5 * sample_time_ + static_cast<double>(kStandardNodeSize + bytes_after) * byte_time_;
    countLost(buffer_begin_);
    nodes.push_back({node, age});
    ++counters_.nodes;
    drop(kStandardNodeSize);
  };
  if (aligned_) {
    if (buffer_.size() < kStandardNodeSize) return;
    if (const auto node = nodeAt(0)) return take(*node, 0);
    ++counters_.bad_check_bits;
    aligned_ = false;
  }
  while (buffer_.size() >= kWindow) {
    bool good = true;
    for (std::size_t i = 0; i < kAlignNodes && good; ++i) good = nodeAt(i).has_value();
    if (!good) {
      drop(1);
      ++counters_.skipped_bytes;
      continue;
    }
    aligned_ = true;
    while (buffer_.size() >= kStandardNodeSize) take(*nodeAt(0), buffer_.size() - kStandardNodeSize);
  }
}

void StreamDecoder::pushCapsule(std::vector<TimedNode>& nodes) {
  while (buffer_.size() >= format_.size) {
    const std::span<const std::uint8_t> bytes{buffer_.data(), format_.size};
    const auto head = parseCapsuleHead(bytes, format_.angle_at);
    if (!head) {
      if (aligned_ || hasCapsuleSync(bytes)) ++counters_.bad_checksums;
      aligned_ = false;
      held_head_.reset();
      drop(1);
      ++counters_.skipped_bytes;
      continue;
    }
    if (head->start && !first_capsule_) {
      ++counters_.encoder_resets;
      held_head_.reset();
    }
    first_capsule_ = false;
    aligned_ = true;
    if (held_head_) decodeHeld(*head, nodes);
    held_head_ = head;
    held_begin_ = buffer_begin_;
    std::copy(bytes.begin(), bytes.end(), held_.begin());
    drop(format_.size);
  }
}

void StreamDecoder::decodeHeld(const CapsuleHead& next_head, std::vector<TimedNode>& nodes) {
  // A motor's speed changes slowly. If the angle jumps, capsules are missing that no damage tells of.
  const int width = CapsuleSpan(held_head_->start_angle_q6, next_head.start_angle_q6, 1).widthQ6();
  const int last_width = std::exchange(width_q6_, width);
  if (width > kHalfTurnQ6 || (last_width > 0 && (2 * width > 3 * last_width || 3 * width < 2 * last_width))) {
    ++counters_.wild_angles;
    width_q6_ = 0;
    return;
  }
  const std::span<const std::uint8_t> held{held_.data(), format_.size}, next{buffer_.data(), format_.size};
  switch (type_) {
    case AnswerType::kExpressCapsules:
      return emit(decodeExpress(*parseExpressCapsule(held), next_head.start_angle_q6), nodes);
    case AnswerType::kUltraCapsules:
      return emit(decodeUltra(*parseUltraCapsule(held), *parseUltraCapsule(next)), nodes);
    case AnswerType::kUltraDenseCapsules:
      return emit(decodeUltraDense(*parseUltraDenseCapsule(held), next_head.start_angle_q6), nodes);
    default:
      return emit(decodeDense(*parseDenseCapsule(held), next_head.start_angle_q6), nodes);
  }
}

template <typename Nodes>
void StreamDecoder::emit(const Nodes& decoded, std::vector<TimedNode>& nodes) {
  countLost(held_begin_);
  for (int k = 0; k < format_.samples; ++k) {
    // Age at the arrival of the capsule after the one that holds the sample.
    const double age = sample_time_ * (1.5 + format_.samples + (format_.samples - 1 - k)) +
                       static_cast<double>(format_.size) * byte_time_;
    nodes.push_back({decoded[static_cast<std::size_t>(k)], age});
  }
  counters_.nodes += static_cast<std::uint64_t>(format_.samples);
}

}  // namespace slam::rplidar
