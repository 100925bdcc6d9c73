// SPDX-License-Identifier: BSD-3-Clause
#include "firmware_if/robolink.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>

#include "firmware_if/little_endian.hpp"

namespace slam::robolink {
namespace {

constexpr std::uint8_t kHeader = 0xFF;
constexpr std::size_t kLengthAt = 4, kCommandAt = 6;
constexpr std::size_t kMaxLength = kMaxPayload + 1;

using little_endian::Bytes;
using little_endian::floatAt;
using little_endian::putFloat;
using little_endian::putFloats;
using little_endian::putWord;
using little_endian::readFloats;
using little_endian::wordAt;

}  // namespace

std::uint8_t checksum(Bytes bytes) {
  std::uint32_t sum = 0;
  for (const std::uint8_t byte : bytes) sum += byte;
  return static_cast<std::uint8_t>(sum % 255);
}

std::size_t encodeFrame(std::uint8_t sender, std::uint8_t receiver, Command command, Bytes payload,
                        std::span<std::uint8_t> out) {
  const std::size_t size = payload.size() + kOverhead, length = payload.size() + 1;
  if (payload.size() > kMaxPayload || out.size() < size) return 0;
  out[0] = out[1] = kHeader;
  out[2] = sender;
  out[3] = receiver;
  out[4] = static_cast<std::uint8_t>(length >> 8);
  out[5] = static_cast<std::uint8_t>(length & 0xFF);
  out[6] = static_cast<std::uint8_t>(command);
  std::copy(payload.begin(), payload.end(), out.begin() + kCommandAt + 1);
  out[size - 1] = checksum(out.first(size - 1));
  return size;
}

std::array<std::uint8_t, kQuestionSize> question(Command command) {
  std::array<std::uint8_t, kQuestionSize> frame{};
  encodeFrame(kMaster, kSlave, command, {}, frame);
  return frame;
}

void Decoder::drop(std::size_t bytes) {
  std::copy(buffer_.begin() + static_cast<std::ptrdiff_t>(bytes), buffer_.begin() + static_cast<std::ptrdiff_t>(size_),
            buffer_.begin());
  size_ -= bytes;
}

std::optional<Frame> Decoder::push(std::uint8_t byte) {
  if (delivered_ > 0) {
    drop(delivered_);
    delivered_ = 0;
  }
  buffer_[size_++] = byte;  // flush() below never leaves the buffer full
  return flush();
}

std::optional<Frame> Decoder::flush() {
  if (delivered_ > 0) {
    drop(delivered_);
    delivered_ = 0;
  }
  const auto skip = [this] {
    ++counters_.skipped_bytes;
    drop(1);
  };
  while (size_ > 0) {
    if (buffer_[0] != kHeader || (size_ > 1 && buffer_[1] != kHeader)) {
      skip();
      continue;
    }
    if (size_ > 2 && buffer_[2] == kHeader) {  // a stray FF before the header: no id is FF
      skip();
      continue;
    }
    if (size_ < kCommandAt) return std::nullopt;
    const std::size_t length = static_cast<std::size_t>(buffer_[kLengthAt]) << 8 | buffer_[kLengthAt + 1];
    if (length == 0 || length > kMaxLength) {
      ++counters_.bad_lengths;
      skip();
      continue;
    }
    const std::size_t frame_size = kCommandAt + length + 1;
    if (size_ < frame_size) return std::nullopt;
    if (checksum({buffer_.data(), frame_size - 1}) != buffer_[frame_size - 1]) {
      ++counters_.bad_checksums;
      skip();
      continue;
    }
    if (buffer_[2] != sender_ || buffer_[3] != own_) {
      ++counters_.foreign_frames;
      drop(frame_size);
      continue;
    }
    ++counters_.frames;
    delivered_ = frame_size;
    return Frame{buffer_[2], buffer_[3], buffer_[kCommandAt], Bytes(buffer_.data() + kCommandAt + 1, length - 1)};
  }
  return std::nullopt;
}

std::array<std::uint8_t, kCoordinateSize> encodeCoordinate(const Coordinate& value) {
  std::array<std::uint8_t, kCoordinateSize> bytes{};
  putFloat(bytes, 0, value.x);
  putFloat(bytes, 4, value.y);
  putFloat(bytes, 8, value.z);
  return bytes;
}

std::optional<Coordinate> parseCoordinate(Bytes payload) {
  std::array<float, 3> values{};
  if (payload.size() != kCoordinateSize || !readFloats(payload, 0, values)) return std::nullopt;
  return Coordinate{values[0], values[1], values[2]};
}

std::array<std::uint8_t, kMotorVectorSize> encodeMotorVector(const MotorVector& value) {
  std::array<std::uint8_t, kMotorVectorSize> bytes{};
  for (std::size_t i = 0; i < value.size(); ++i) putFloat(bytes, 4 * i, value[i]);
  return bytes;
}

std::optional<MotorVector> parseMotorVector(Bytes payload) {
  MotorVector values{};
  if (payload.size() != kMotorVectorSize || !readFloats(payload, 0, values)) return std::nullopt;
  return values;
}

std::array<std::uint8_t, kImuSize> encodeImu(const Imu& value) {
  std::array<std::uint8_t, kImuSize> bytes{};
  bytes[0] = value.online;
  for (std::size_t i = 0; i < 3; ++i) putWord(bytes, 1 + 2 * i, value.update_rates[i]);
  putFloats(bytes, 7, value.gyro);
  putFloats(bytes, 19, value.accel);
  return bytes;
}

std::optional<Imu> parseImu(Bytes payload) {
  Imu imu;
  if (payload.size() != kImuSize) return std::nullopt;
  imu.online = payload[0];
  for (std::size_t i = 0; i < 3; ++i) imu.update_rates[i] = wordAt(payload, 1 + 2 * i);
  if (!readFloats(payload, 7, imu.gyro) || !readFloats(payload, 19, imu.accel)) return std::nullopt;
  return imu;
}

LocalTime localTimeAt(std::int64_t seconds) {
  using namespace std::chrono;
  const sys_seconds instant{std::chrono::seconds(seconds)};
  const sys_days day = floor<days>(instant);
  const year_month_day date(day);
  const hh_mm_ss time(instant - day);
  const auto byte = [](auto value) { return static_cast<std::uint8_t>(value); };
  return {true,
          static_cast<std::uint16_t>(static_cast<int>(date.year())),
          byte(static_cast<unsigned>(date.month())),
          byte(static_cast<unsigned>(date.day())),
          byte(weekday(day).iso_encoding()),
          byte(time.hours().count()),
          byte(time.minutes().count()),
          byte(time.seconds().count())};
}

std::array<std::uint8_t, kSystemInfoSize> encodeSystemInfo(const SystemInfo& value) {
  std::array<std::uint8_t, kSystemInfoSize> bytes{};
  putFloats(bytes, 0,
            std::array{value.system_time, value.cpu_temperature, value.cpu_usage, value.battery, value.power_remain});
  const LocalTime& time = value.local_time;
  bytes[20] = time.valid ? 1 : 0;
  putWord(bytes, 21, time.year);
  const std::array rest{time.month, time.day, time.weekday, time.hour, time.minute, time.second};
  std::copy(rest.begin(), rest.end(), bytes.begin() + 23);
  return bytes;
}

std::optional<SystemInfo> parseSystemInfo(Bytes payload) {
  std::array<float, 5> values{};
  if (payload.size() != kSystemInfoSize || !readFloats(payload, 0, values)) return std::nullopt;
  const LocalTime time{payload[20] != 0, wordAt(payload, 21), payload[23], payload[24],
                       payload[25],      payload[26],         payload[27], payload[28]};
  return SystemInfo{values[0], values[1], values[2], values[3], values[4], time};
}

std::array<std::uint8_t, kChassisSize> encodeChassis(const ChassisParameters& value) {
  std::array<std::uint8_t, kChassisSize> bytes{};
  bytes[0] = static_cast<std::uint8_t>(value.type);
  putFloats(bytes, 1, std::array{value.wheel_radius, value.body_radius, value.speed_low_filter});
  bytes[13] = value.imu_fusion;
  bytes[14] = value.control_enable;
  putFloats(bytes, 15, value.max_speed);
  putFloats(bytes, 27, value.max_acceleration);
  return bytes;
}

std::optional<ChassisParameters> parseChassis(Bytes payload) {
  ChassisParameters value;
  std::array<float, 3> sizes{};
  if (payload.size() != kChassisSize || !readFloats(payload, 1, sizes)) return std::nullopt;
  if (!readFloats(payload, 15, value.max_speed) || !readFloats(payload, 27, value.max_acceleration)) {
    return std::nullopt;
  }
  value.type = static_cast<ChassisType>(payload[0]);
  value.wheel_radius = sizes[0];
  value.body_radius = sizes[1];
  value.speed_low_filter = sizes[2];
  value.imu_fusion = payload[13];
  value.control_enable = payload[14];
  return value;
}

}  // namespace slam::robolink
