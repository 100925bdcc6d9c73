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
constexpr std::size_t kA9Values = 8;  // behind 8 bytes whose meaning is not known

template <std::size_t N>
std::array<std::uint8_t, 8 + 4 * N + kA9Overhead> encodeValues(const std::array<float, N>& values) {
  std::array<std::uint8_t, 8 + 4 * N + kA9Overhead> frame{0xAA, 0x55, 8 + 4 * N};
  for (std::size_t i = 0; i < N; ++i) putFloat(frame, 3 + kA9Values + 4 * i, values[i]);
  const std::uint16_t crc = crc16(Bytes(frame).subspan(2, frame.size() - 4));
  frame[frame.size() - 2] = static_cast<std::uint8_t>(crc & 0xFF);
  frame[frame.size() - 1] = static_cast<std::uint8_t>(crc >> 8);
  return frame;
}

std::uint8_t sumOf(Bytes bytes) {
  std::uint8_t sum = 0;
  for (const std::uint8_t byte : bytes) sum = static_cast<std::uint8_t>(sum + byte);
  return sum;
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

std::optional<A9Motion> parseA9Motion(Bytes data) {
  A9Motion value;
  if (data.size() != kA9MotionLength || !readFloats(data, kA9Values, value.gyro) ||
      !readFloats(data, kA9Values + 12, value.accel) || !readFloats(data, kA9Values + 24, value.magnetic)) {
    return std::nullopt;
  }
  return value;
}

std::optional<A9Attitude> parseA9Attitude(Bytes data) {
  std::array<float, 3> values{};
  if (data.size() != kA9AttitudeLength || !readFloats(data, kA9Values, values)) return std::nullopt;
  return A9Attitude{values[0], values[1], values[2]};
}

std::array<std::uint8_t, kB6Frame> encodeB6(const B6Frame& value) {
  std::array<std::uint8_t, kB6Frame> frame{0x55, static_cast<std::uint8_t>(value.type)};
  for (std::size_t i = 0; i < value.raw.size(); ++i) {
    const auto bits = static_cast<std::uint16_t>(value.raw[i]);
    frame[2 + 2 * i] = static_cast<std::uint8_t>(bits & 0xFF);
    frame[3 + 2 * i] = static_cast<std::uint8_t>(bits >> 8);
  }
  frame[kB6Frame - 1] = sumOf(Bytes(frame).first(kB6Frame - 1));
  return frame;
}

template <std::size_t Size>
void FrameBuffer<Size>::drop(std::size_t bytes) {
  std::copy(buffer_.begin() + static_cast<std::ptrdiff_t>(bytes), buffer_.begin() + static_cast<std::ptrdiff_t>(size_),
            buffer_.begin());
  size_ -= bytes;
}

std::optional<A9Decoder::Data> A9Decoder::push(std::uint8_t byte) {
  drop(delivered_);
  delivered_ = 0;
  append(byte);  // flush() never leaves the buffer full
  return flush();
}

std::optional<A9Decoder::Data> A9Decoder::flush() {
  drop(delivered_);
  delivered_ = 0;
  const auto skip = [this] {
    ++counters_.skipped_bytes;
    drop(1);
  };
  while (size_ > 0) {
    if (buffer_[0] != 0xAA || (size_ > 1 && buffer_[1] != 0x55) ||
        (size_ > 2 && buffer_[2] != kA9MotionLength && buffer_[2] != kA9AttitudeLength)) {
      skip();
      continue;
    }
    if (size_ < 3 || size_ < buffer_[2] + kA9Overhead) return std::nullopt;
    const std::size_t length = buffer_[2];
    const std::uint16_t crc = crc16(Bytes(buffer_).subspan(2, length + 1));
    if (buffer_[length + 3] != (crc & 0xFF) || buffer_[length + 4] != crc >> 8) {
      ++counters_.bad_checksums;
      skip();
      continue;
    }
    ++counters_.frames;
    delivered_ = length + kA9Overhead;
    return Bytes(buffer_).subspan(3, length);
  }
  return std::nullopt;
}

std::optional<B6Frame> B6Decoder::push(std::uint8_t byte) {
  append(byte);
  return flush();
}

std::optional<B6Frame> B6Decoder::flush() {
  const auto skip = [this] {
    ++counters_.skipped_bytes;
    drop(1);
  };
  while (size_ > 0) {
    if (buffer_[0] != 0x55 || (size_ > 1 && (buffer_[1] < 0x51 || buffer_[1] > 0x54))) {
      skip();
      continue;
    }
    if (size_ < kB6Frame) return std::nullopt;
    if (sumOf(Bytes(buffer_).first(kB6Frame - 1)) != buffer_[kB6Frame - 1]) {
      ++counters_.bad_checksums;
      skip();
      continue;
    }
    ++counters_.frames;
    B6Frame frame{static_cast<B6Type>(buffer_[1])};
    for (std::size_t i = 0; i < frame.raw.size(); ++i) {
      frame.raw[i] = static_cast<std::int16_t>(buffer_[2 + 2 * i] | buffer_[3 + 2 * i] << 8);
    }
    drop(kB6Frame);
    return frame;
  }
  return std::nullopt;
}

}  // namespace slam::hfi
