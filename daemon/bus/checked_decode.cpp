// SPDX-License-Identifier: BSD-3-Clause
#include "bus/checked_decode.hpp"

#include <algorithm>

#include "core/pseudo_laser.hpp"

namespace slam {
namespace {

using Bytes = std::span<const std::uint8_t>;
constexpr std::size_t kFingerprint = 8;

/// Big-endian int32 at `offset`, or std::nullopt past the end.
std::optional<std::int32_t> int32At(Bytes data, std::size_t offset) {
  if (data.size() < offset + 4) return std::nullopt;
  std::uint32_t value = 0;
  for (std::size_t i = 0; i < 4; ++i) value = value << 8 | data[offset + i];
  return static_cast<std::int32_t>(value);
}

/// A message of `head` bytes, then a count, then `per_element` bytes each.
bool hasArraySize(Bytes data, std::size_t head, std::size_t per_element, std::int32_t max_count) {
  const auto count = int32At(data, head);
  return count && *count >= 0 && *count <= max_count &&
         data.size() == head + 4 + static_cast<std::size_t>(*count) * per_element;
}

/// End of the string that begins at `offset`: a count (terminator included), the characters and the only zero. One more
/// inside would let a name pass that another program reads as a shorter one.
std::optional<std::size_t> stringEnd(Bytes data, std::size_t offset) {
  const auto count = int32At(data, offset);
  if (!count || *count < 1 || static_cast<std::size_t>(*count) > data.size() - offset - 4) return std::nullopt;
  const std::size_t end = offset + 4 + static_cast<std::size_t>(*count);
  const auto zero = std::find(data.begin() + static_cast<std::ptrdiff_t>(offset + 4), data.end(), 0);
  return zero - data.begin() + 1 == static_cast<std::ptrdiff_t>(end) ? std::optional(end) : std::nullopt;
}

/// Walks through a message's fields, to see whether they end where the message does.
class Fields {
 public:
  Fields(Bytes data, std::size_t at) : data_(data), at_(at) {}
  void skip(std::size_t size) { at_ = at_ && size <= data_.size() - *at_ ? std::optional(*at_ + size) : std::nullopt; }
  void string() { at_ = at_ ? stringEnd(data_, *at_) : std::nullopt; }
  template <typename Element>
  void list(Element&& element) {
    const auto count = at_ ? int32At(data_, *at_) : std::nullopt;
    skip(4);
    if (!count || *count < 0) at_.reset();
    for (std::int32_t i = 0; at_ && i < *count; ++i) element();
  }
  bool areAll() const { return at_ == data_.size(); }

 private:
  Bytes data_;
  std::optional<std::size_t> at_;
};

template <typename Message>
std::optional<Message> decode(Bytes data) {
  Message message{};
  const int used = message.decode(data.data(), 0, static_cast<int>(data.size()));
  return used == static_cast<int>(data.size()) ? std::optional(std::move(message)) : std::nullopt;
}

}  // namespace

template <>
std::optional<scan_t> decodeChecked(Bytes data) {
  constexpr std::size_t kHead = kFingerprint + 8 + 4 + 4;
  return hasArraySize(data, kHead, 16, 65536) ? decode<scan_t>(data) : std::nullopt;
}

template <>
std::optional<wheels_t> decodeChecked(Bytes data) {
  constexpr std::size_t kHead = kFingerprint + 8 + 24 + 1;
  return hasArraySize(data, kHead, 8, 8) ? decode<wheels_t>(data) : std::nullopt;
}

template <>
std::optional<imu_t> decodeChecked(Bytes data) {
  return data.size() == kFingerprint + 8 + 48 ? decode<imu_t>(data) : std::nullopt;
}

template <>
std::optional<depth_t> decodeChecked(Bytes data) {
  constexpr std::size_t kHead = kFingerprint + 8 + 4 + 4, kBeam = 4 + 4 + 1, kSurface = 2 + 4 + 4;
  const auto beams = int32At(data, kHead);
  if (!beams || *beams < 0 || *beams > PseudoLaser::kCapacity) return std::nullopt;
  const std::size_t surfaces = kHead + 4 + static_cast<std::size_t>(*beams) * kBeam;
  return hasArraySize(data, surfaces, kSurface, PseudoLaser::kSurfaceCapacity) ? decode<depth_t>(data) : std::nullopt;
}

template <>
std::optional<drive_t> decodeChecked(Bytes data) {
  return data.size() == kFingerprint + 8 + 24 ? decode<drive_t>(data) : std::nullopt;
}

template <>
std::optional<command_t> decodeChecked(Bytes data) {
  const auto verb_end = stringEnd(data, kFingerprint + 8 + 4);
  const auto argument_end = verb_end ? stringEnd(data, *verb_end) : std::nullopt;
  return argument_end && data.size() == *argument_end + 24 ? decode<command_t>(data) : std::nullopt;
}

template <>
std::optional<ack_t> decodeChecked(Bytes data) {
  return stringEnd(data, kFingerprint + 8 + 4 + 1) == data.size() ? decode<ack_t>(data) : std::nullopt;
}

template <>
std::optional<config_t> decodeChecked(Bytes data) {
  constexpr std::size_t kHead = kFingerprint + 8;
  if (data.size() < kHead) return std::nullopt;
  Fields fields(data, kHead);
  fields.string();
  fields.string();
  fields.skip(4);
  fields.string();
  fields.string();
  return fields.areAll() ? decode<config_t>(data) : std::nullopt;
}

template <>
std::optional<health_t> decodeChecked(Bytes data) {
  constexpr std::size_t kHead = kFingerprint + 8 + 8 + 1;
  if (data.size() < kHead) return std::nullopt;
  Fields fields(data, kHead);
  fields.string();
  fields.skip(3 * 8);
  fields.list([&] {  // devices
    fields.string();
    fields.skip(1);
    fields.string();
    fields.skip(5 * 8);
  });
  fields.list([&] {  // stages
    fields.string();
    fields.skip(4 * 8);
  });
  fields.list([&] {  // counters
    fields.string();
    fields.skip(8);
  });
  return fields.areAll() ? decode<health_t>(data) : std::nullopt;
}

template <>
std::optional<problems_t> decodeChecked(Bytes data) {
  constexpr std::size_t kHead = kFingerprint + 8;
  if (data.size() < kHead) return std::nullopt;
  Fields fields(data, kHead);
  fields.list([&] {
    fields.string();
    fields.string();
    fields.skip(1);
    fields.list([&] { fields.skip(8); });
    fields.list([&] { fields.string(); });
    for (int i = 0; i < 3; ++i) fields.string();
  });
  return fields.areAll() ? decode<problems_t>(data) : std::nullopt;
}

template <>
std::optional<pose_estimate_t> decodeChecked(Bytes data) {
  return data.size() == kFingerprint + 8 + 4 + 15 * 8 + 1 + 4 ? decode<pose_estimate_t>(data) : std::nullopt;
}

template <>
std::optional<map_edit_t> decodeChecked(Bytes data) {
  constexpr std::size_t kHead = kFingerprint + 8 + 5 * 4;
  if (data.size() < kHead) return std::nullopt;
  Fields fields(data, kHead);
  for (int i = 0; i < 3; ++i) fields.string();
  fields.list([&] { fields.skip(2 * 8); });  // x and y, one list behind the other
  fields.skip(4 * 8);
  return fields.areAll() ? decode<map_edit_t>(data) : std::nullopt;
}

template <>
std::optional<odometry_t> decodeChecked(Bytes data) {
  return decode<odometry_t>(data);  // of one size: its decoder reads no lengths
}

template <>
std::optional<map_meta_t> decodeChecked(Bytes data) {
  return data.size() == kFingerprint + 8 + 4 + 3 * 8 + 7 * 4 ? decode<map_meta_t>(data) : std::nullopt;
}

template <>
std::optional<map_tile_t> decodeChecked(Bytes data) {
  constexpr std::size_t kHead = kFingerprint + 8 + 4 * 4;
  constexpr std::int32_t kLongestSide = 255;  // [cells] more do not fit into a datagram
  const auto side = int32At(data, kHead - 4), cells = int32At(data, kHead);
  if (!side || !cells || *side < 0 || *side > kLongestSide || *cells != *side * *side) return std::nullopt;
  return hasArraySize(data, kHead, 1, kLongestSide * kLongestSide) ? decode<map_tile_t>(data) : std::nullopt;
}

}  // namespace slam
