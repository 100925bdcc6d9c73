// SPDX-License-Identifier: BSD-3-Clause
#include "firmware_if/hfi_imu.hpp"

#include <algorithm>
#include <cmath>

#include "firmware_if/little_endian.hpp"

namespace slam::hfi {
namespace {

using little_endian::Bytes;
using little_endian::putFloat;
using little_endian::readFloats;
constexpr std::size_t kA9Values = 11;  // behind the length and 8 bytes whose meaning is not known

template <std::size_t N>
std::array<std::uint8_t, 8 + 4 * N + kA9Overhead> encodeValues(const std::array<float, N>& values) {
  std::array<std::uint8_t, 8 + 4 * N + kA9Overhead> frame{0xAA, 0x55, 8 + 4 * N};
  for (std::size_t i = 0; i < N; ++i) putFloat(frame, kA9Values + 4 * i, values[i]);
  const std::uint16_t crc = crc16(Bytes(frame).subspan(2, frame.size() - 4));
  little_endian::putWord(frame, frame.size() - 2, crc);
  return frame;
}

}  // namespace

std::uint16_t crc16(Bytes bytes) {
  std::uint16_t crc = 0xFFFF;
  for (const std::uint8_t byte : bytes) {
    crc = static_cast<std::uint16_t>(crc ^ byte);
    for (int bit = 0; bit < 8; ++bit) {
      crc = static_cast<std::uint16_t>((crc & 1) != 0 ? crc >> 1 ^ 0xA001 : crc >> 1);
    }
  }
  return crc;
}

std::array<std::uint8_t, kA9MotionLength + kA9Overhead> encodeA9(const A9Motion& value) {
  std::array<float, 9> values{};
  std::copy(value.gyro.begin(), value.gyro.end(), values.begin());
  std::copy(value.accel.begin(), value.accel.end(), values.begin() + 3);
  std::copy(value.magnetic.begin(), value.magnetic.end(), values.begin() + 6);
  return encodeValues(values);
}

std::array<std::uint8_t, kA9AttitudeLength + kA9Overhead> encodeA9(const A9Attitude& value) {
  return encodeValues(std::array{value.roll, value.pitch, value.yaw});
}

std::optional<A9Motion> parseA9Motion(Bytes frame) {
  A9Motion value;
  if (frame.size() != kA9MaxFrame || !readFloats(frame, kA9Values, value.gyro) ||
      !readFloats(frame, kA9Values + 12, value.accel) || !readFloats(frame, kA9Values + 24, value.magnetic)) {
    return std::nullopt;
  }
  return value;
}

std::optional<std::size_t> A9Format::sizeOf(Bytes bytes) {
  if (bytes[0] != 0xAA || (bytes.size() > 1 && bytes[1] != 0x55)) return 0;
  if (bytes.size() < 3) return std::nullopt;
  const std::uint8_t length = bytes[2];
  return length == kA9MotionLength || length == kA9AttitudeLength ? length + kA9Overhead : 0;
}

bool A9Format::isGood(Bytes frame) {
  return little_endian::wordAt(frame, frame.size() - 2) == crc16(frame.subspan(2, frame.size() - 4));
}

}  // namespace slam::hfi
