// SPDX-License-Identifier: BSD-3-Clause
#include "firmware_if/can_xsens.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace slam::can::xsens {
namespace {

constexpr float kRateScale = 1.0F / 512.0F;          // [rad/s]
constexpr float kAccelerationScale = 1.0F / 256.0F;  // [m/s^2]
constexpr float kQuaternionScale = 1.0F / 32767.0F;  // [1]

/// Big-endian 16-bit integers; what does not fit is cut off at the largest.
template <std::size_t N>
Frame encodeShorts(std::uint32_t id, const std::array<float, N>& values, float scale) {
  using Limits = std::numeric_limits<std::int16_t>;
  Frame frame{.id = id, .size = 2 * N};
  for (std::size_t i = 0; i < N; ++i) {
    const float steps =
        std::clamp(std::round(values[i] / scale), static_cast<float>(Limits::min()), static_cast<float>(Limits::max()));
    const auto raw = static_cast<std::uint16_t>(static_cast<std::int16_t>(steps));
    frame.data[2 * i] = static_cast<std::uint8_t>(raw >> 8);
    frame.data[2 * i + 1] = static_cast<std::uint8_t>(raw & 0xFF);
  }
  return frame;
}

template <std::size_t N>
std::optional<std::array<float, N>> parseShorts(std::uint32_t id, const Frame& frame, float scale) {
  if (!isData(frame, id, 2 * N)) return std::nullopt;
  std::array<float, N> values{};
  for (std::size_t i = 0; i < N; ++i) {
    const auto raw = static_cast<std::uint16_t>(frame.data[2 * i] << 8 | frame.data[2 * i + 1]);
    values[i] = scale * static_cast<float>(static_cast<std::int16_t>(raw));
  }
  return values;
}

}  // namespace

Frame encodeSampleTime(std::uint32_t ticks) {
  Frame frame{.id = kSampleTime, .size = 4};
  for (std::size_t i = 4; i-- > 0; ticks >>= 8) frame.data[i] = static_cast<std::uint8_t>(ticks);
  return frame;
}

std::optional<std::uint32_t> parseSampleTime(const Frame& frame) {
  if (!isData(frame, kSampleTime, 4)) return std::nullopt;
  std::uint32_t ticks = 0;
  for (std::size_t i = 0; i < 4; ++i) ticks = ticks << 8 | frame.data[i];
  return ticks;
}

std::int64_t TickCounter::count(std::uint32_t ticks) {
  const bool restarted = !last_ || static_cast<std::int32_t>(ticks - *last_) < 0;
  count_ = restarted ? ticks : count_ + (ticks - *last_);
  last_ = ticks;
  return count_;
}

Frame encodeQuaternion(const Quaternion& value) { return encodeShorts(kQuaternion, value, kQuaternionScale); }

Frame encodeRateOfTurn(const Vector3& value) { return encodeShorts(kRateOfTurn, value, kRateScale); }
std::optional<Vector3> parseRateOfTurn(const Frame& frame) { return parseShorts<3>(kRateOfTurn, frame, kRateScale); }

Frame encodeAcceleration(const Vector3& value) { return encodeShorts(kAcceleration, value, kAccelerationScale); }
std::optional<Vector3> parseAcceleration(const Frame& frame) {
  return parseShorts<3>(kAcceleration, frame, kAccelerationScale);
}

}  // namespace slam::can::xsens
