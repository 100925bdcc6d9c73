// SPDX-License-Identifier: BSD-3-Clause
#include "tools/sim/lidar/other_lidar.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace slam::sim {
namespace {

using Bytes = std::vector<std::uint8_t>;

constexpr Duration kPacket = std::chrono::milliseconds(8);
constexpr double kSample = 0.6;  // [deg]

void put(Bytes& bytes, unsigned value) {
  bytes.push_back(static_cast<std::uint8_t>(value & 0xFF));
  bytes.push_back(static_cast<std::uint8_t>(value >> 8 & 0xFF));
}

unsigned millimetres(double range) {
  return static_cast<unsigned>(std::clamp(std::lround(1000.0 * range), 0L, 16383L));
}
unsigned hundredths(double degrees) { return static_cast<unsigned>(std::lround(100.0 * degrees)) % 36000; }

std::uint8_t crc8(const Bytes& bytes) {
  std::uint8_t crc = 0;
  for (const std::uint8_t byte : bytes) {
    crc ^= byte;
    for (int bit = 0; bit < 8; ++bit) crc = static_cast<std::uint8_t>((crc & 0x80) != 0 ? crc << 1 ^ 0x4D : crc << 1);
  }
  return crc;
}

Bytes ldrobot(double from, double to, const std::vector<double>& ranges) {
  Bytes bytes = {0x54, 0x2C};
  put(bytes, 3600);  // [deg/s]
  put(bytes, hundredths(from));
  for (const double range : ranges) {
    put(bytes, millimetres(range));
    bytes.push_back(200);
  }
  put(bytes, hundredths(to));
  put(bytes, hundredths(from) % 30000);
  bytes.push_back(crc8(bytes));
  return bytes;
}

Bytes ydlidar(double from, double to, const std::vector<double>& ranges) {
  const auto angle = [](double degrees) { return static_cast<unsigned>(std::lround(64.0 * degrees)) << 1 | 1; };
  Bytes bytes = {0xAA, 0x55, 0x00, static_cast<std::uint8_t>(ranges.size())};
  put(bytes, angle(from));
  put(bytes, angle(to));
  unsigned check = 0x55AA ^ (static_cast<unsigned>(ranges.size()) << 8) ^ angle(from) ^ angle(to);
  for (const double range : ranges) check ^= 4 * millimetres(range);
  put(bytes, check);
  for (const double range : ranges) put(bytes, 4 * millimetres(range));
  return bytes;
}

Bytes neato(double from, const std::vector<double>& ranges) {
  Bytes bytes = {0xFA, static_cast<std::uint8_t>(0xA0 + static_cast<int>(from / 4.0) % 90)};
  put(bytes, 300 * 64);
  for (std::size_t i = 0; i < 4; ++i) {
    put(bytes, millimetres(ranges[i]));
    put(bytes, 100);
  }
  unsigned sum = 0;
  for (std::size_t i = 0; i < 10; ++i) sum = (sum << 1) + (bytes[2 * i] | static_cast<unsigned>(bytes[2 * i + 1]) << 8);
  put(bytes, ((sum & 0x7FFF) + (sum >> 15)) & 0x7FFF);
  return bytes;
}

}  // namespace

void OtherLidar::stream(Make make, Timestamp now, const Look& look, std::vector<std::uint8_t>& out) {
  if (make == kNone) return;
  for (next_ = std::max(next_, now - 4 * kPacket); next_ <= now; next_ += kPacket) {
    const int samples = make == kLdrobot ? 12 : make == kYdlidar ? 40 : 4;
    const double from = angle_;
    std::vector<double> ranges;
    for (int i = 0; i < samples; ++i) ranges.push_back(look(-(from + i * kSample) * std::numbers::pi / 180.0));
    const double to = std::fmod(from + (samples - 1) * kSample, 360.0);
    angle_ = std::fmod(from + samples * kSample, 360.0);
    const Bytes packet = make == kLdrobot   ? ldrobot(from, to, ranges)
                         : make == kYdlidar ? ydlidar(from, to, ranges)
                                            : neato(from, ranges);
    out.insert(out.end(), packet.begin(), packet.end());
  }
}

}  // namespace slam::sim
