// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/imu/codec/xsens_messages.hpp"

#include <bit>

namespace slam::xsens {
namespace {

using Bytes = std::span<const std::uint8_t>;

constexpr std::uint8_t kPreamble = 0xFA, kBusId = 0xFF, kExtended = 0xFF;
constexpr std::size_t kHead = 4, kExtendedHead = 6;
/// Identifiers of blocks, and what their lowest four bits are for: format of the numbers, and a frame of axes that
/// orientations have.
constexpr std::uint16_t kCounter = 0x1020, kTime = 0x1060, kAcceleration = 0x4020, kTurnRate = 0x8020;
constexpr std::uint16_t kGroup = 0xFFF0, kNumbers = 0x0003;

std::uint64_t bigAt(Bytes bytes, std::size_t offset, std::size_t size) {
  std::uint64_t value = 0;
  for (std::size_t i = 0; i < size; ++i) value = value << 8 | bytes[offset + i];
  return value;
}

double singleAt(Bytes bytes, std::size_t offset) {
  return static_cast<double>(std::bit_cast<float>(static_cast<std::uint32_t>(bigAt(bytes, offset, 4))));
}
double fixed20At(Bytes bytes, std::size_t offset) {
  return static_cast<double>(static_cast<std::int32_t>(bigAt(bytes, offset, 4))) / static_cast<double>(1 << 20);
}
/// The fraction's four bytes come first.
double fixed32At(Bytes bytes, std::size_t offset) {
  const auto whole = static_cast<std::int16_t>(bigAt(bytes, offset + 4, 2));
  return whole + static_cast<double>(bigAt(bytes, offset, 4)) / 4294967296.0;
}
double doubleAt(Bytes bytes, std::size_t offset) { return std::bit_cast<double>(bigAt(bytes, offset, 8)); }

struct Numbers {
  std::size_t size;  // [bytes]
  double (*at)(Bytes, std::size_t);
};
constexpr std::array kFormats = {Numbers{4, singleAt}, Numbers{4, fixed20At}, Numbers{6, fixed32At},
                                 Numbers{8, doubleAt}};

std::optional<std::array<double, 3>> vectorOf(Bytes block, std::uint16_t id) {
  const Numbers& numbers = kFormats[id & kNumbers];
  if (block.size() != 3 * numbers.size) return std::nullopt;
  std::array<double, 3> vector{};
  for (std::size_t i = 0; i < vector.size(); ++i) vector[i] = numbers.at(block, i * numbers.size);
  return vector;
}

std::size_t headOf(Bytes message) { return message[3] == kExtended ? kExtendedHead : kHead; }

std::uint8_t sumOf(Bytes bytes) {
  std::uint8_t sum = 0;
  for (const std::uint8_t byte : bytes) sum = static_cast<std::uint8_t>(sum + byte);
  return sum;
}

void putBig(std::vector<std::uint8_t>& out, std::uint64_t value, std::size_t size) {
  while (size-- > 0) out.push_back(static_cast<std::uint8_t>(value >> (8 * size)));
}

void putVector(std::vector<std::uint8_t>& out, std::uint16_t id, const std::array<double, 3>& vector) {
  putBig(out, id, 2);
  putBig(out, 12, 1);
  for (const double value : vector) putBig(out, std::bit_cast<std::uint32_t>(static_cast<float>(value)), 4);
}

}  // namespace

std::optional<std::size_t> Format::sizeOf(Bytes bytes) {
  if (bytes[0] != kPreamble || (bytes.size() > 1 && bytes[1] != kBusId)) return 0;
  if (bytes.size() < kHead) return std::nullopt;
  if (bytes[3] != kExtended) return kOverhead + bytes[3];
  if (bytes.size() < kExtendedHead) return std::nullopt;
  const std::size_t length = bigAt(bytes, kHead, 2);
  return length >= kExtended && length <= kMostData ? kExtendedHead + length + 1 : 0;
}

bool Format::isGood(Bytes message) { return sumOf(message.subspan(1)) == 0; }

Message parse(Bytes bytes) {
  const std::size_t head = headOf(bytes);
  return {bytes[2], bytes.subspan(head, bytes.size() - head - 1)};
}

std::optional<Motion> parseMotion(Bytes data) {
  constexpr std::size_t kBlockHead = 3;
  Motion motion;
  while (!data.empty()) {
    if (data.size() < kBlockHead || data.size() < kBlockHead + data[2]) return std::nullopt;
    const auto id = static_cast<std::uint16_t>(bigAt(data, 0, 2));
    const Bytes block = data.subspan(kBlockHead, data[2]);
    if (id == kCounter && block.size() == 2) motion.counter = static_cast<std::uint16_t>(bigAt(block, 0, 2));
    if (id == kTime && block.size() == 4) motion.ticks = static_cast<std::uint32_t>(bigAt(block, 0, 4));
    if ((id & kGroup) == kAcceleration) motion.acceleration = vectorOf(block, id);
    if ((id & kGroup) == kTurnRate) motion.turn_rate = vectorOf(block, id);
    data = data.subspan(kBlockHead + block.size());
  }
  return motion;
}

Outgoing encode(std::uint8_t id) { return {kPreamble, kBusId, id, 0, static_cast<std::uint8_t>(-(kBusId + id))}; }

void encode(const Message& message, std::vector<std::uint8_t>& out) {
  const std::size_t begin = out.size(), size = message.data.size();
  out.insert(out.end(),
             {kPreamble, kBusId, message.id, static_cast<std::uint8_t>(std::min<std::size_t>(size, kExtended))});
  if (size >= kExtended) putBig(out, size, 2);
  out.insert(out.end(), message.data.begin(), message.data.end());
  out.push_back(static_cast<std::uint8_t>(-sumOf(Bytes(out).subspan(begin + 1))));
}

void encode(const Motion& motion, std::vector<std::uint8_t>& out) {
  std::vector<std::uint8_t> data;
  if (motion.counter) {
    putBig(data, std::uint64_t{kCounter} << 8 | 2, 3);
    putBig(data, *motion.counter, 2);
  }
  if (motion.ticks) {
    putBig(data, std::uint64_t{kTime} << 8 | 4, 3);
    putBig(data, *motion.ticks, 4);
  }
  if (motion.acceleration) putVector(data, kAcceleration, *motion.acceleration);
  if (motion.turn_rate) putVector(data, kTurnRate, *motion.turn_rate);
  encode(Message{kData2, data}, out);
}

}  // namespace slam::xsens
