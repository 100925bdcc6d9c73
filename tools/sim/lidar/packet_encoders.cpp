// SPDX-License-Identifier: BSD-3-Clause
#include "tools/sim/lidar/packet_encoders.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "drivers/lidar/codec/ldrobot_packets.hpp"
#include "drivers/lidar/codec/neato_packets.hpp"
#include "drivers/lidar/codec/ydlidar_packets.hpp"
#include "drivers/search/driver_row.hpp"
#include "tools/sim/lidar/cola_emulator.hpp"
#include "tools/sim/lidar/lidar_identity.hpp"
#include "tools/sim/lidar/scip_emulator.hpp"

namespace slam::sim {
namespace {

using Bytes = std::vector<std::uint8_t>;

constexpr std::uint8_t kBright = 200;  // of every echo

void put(Bytes& bytes, long value) {
  bytes.push_back(static_cast<std::uint8_t>(value & 0xFF));
  bytes.push_back(static_cast<std::uint8_t>(value >> 8 & 0xFF));
}

long millimetres(double range, double unit = 1.0) {
  constexpr double kMost = 65532.0;
  return std::lround(std::clamp(1000.0 * range * unit, 0.0, kMost));
}

Bytes ldrobot(const PacketContents& packet) {
  constexpr long kTurn = 36000, kWrap = 30000;  // [0.01 deg], [ms]
  const auto hundredths = [](double degrees) { return std::lround(100.0 * degrees) % kTurn; };
  Bytes bytes = {0x54, 0x2C};
  put(bytes, std::lround(360.0 * packet.turn_rate));
  put(bytes, hundredths(packet.angles.front()));
  for (const double range : packet.ranges) {
    put(bytes, millimetres(range));
    bytes.push_back(kBright);
  }
  put(bytes, hundredths(packet.angles.back()));
  put(bytes, std::chrono::duration_cast<std::chrono::milliseconds>(packet.uptime).count() % kWrap);
  bytes.push_back(slam::ldrobot::crc8(bytes));
  return bytes;
}

/// @param width [bytes] of a sample
Bytes ydlidarPacket(const PacketContents& packet, std::size_t width, bool coin) {
  const auto angle = [](double degrees) { return (std::lround(64.0 * degrees) % (360 * 64)) << 1 | 1; };
  const bool start = packet.angles.back() < packet.angles.front();
  Bytes bytes = {0xAA, 0x55, static_cast<std::uint8_t>(start ? 1 : 0), static_cast<std::uint8_t>(packet.ranges.size())};
  put(bytes, angle(packet.angles.front()));
  put(bytes, angle(packet.angles.back()));
  put(bytes, 0);  // the check
  for (const double range : packet.ranges) {
    const long quarters = millimetres(range) * 4;
    if (width == 3) bytes.push_back(coin ? kBright << 2 & 0xFF : kBright);
    put(bytes, coin ? quarters | kBright >> 6 : quarters);
  }
  const unsigned check = slam::ydlidar::checkOf(bytes, width);
  bytes[8] = static_cast<std::uint8_t>(check & 0xFF);
  bytes[9] = static_cast<std::uint8_t>(check >> 8);
  return bytes;
}
Bytes ydlidarPlain(const PacketContents& packet) { return ydlidarPacket(packet, 2, false); }
Bytes ydlidarBright(const PacketContents& packet) { return ydlidarPacket(packet, 3, false); }
Bytes coin(const PacketContents& packet) { return ydlidarPacket(packet, 3, true); }

std::uint8_t indexOf(const PacketContents& packet, double grid) {
  return static_cast<std::uint8_t>(0xA0 + std::lround(packet.angles.front() / grid) % std::lround(360.0 / grid));
}

Bytes xv11(const PacketContents& packet) {
  constexpr long kInvalid = 0x8035;
  Bytes bytes = {0xFA, indexOf(packet, 4.0)};
  put(bytes, std::lround(60.0 * 64.0 * packet.turn_rate));
  for (const double range : packet.ranges) {
    put(bytes, range > 0.0 ? std::min(millimetres(range), 0x3FFFL) : kInvalid);
    put(bytes, range > 0.0 ? kBright : 0);
  }
  put(bytes, slam::neato::checkOf(bytes));
  return bytes;
}

Bytes lds01(const PacketContents& packet) {
  Bytes bytes = {0xFA, indexOf(packet, 6.0)};
  put(bytes, std::lround(600.0 * packet.turn_rate));
  for (const double range : packet.ranges) {
    put(bytes, range > 0.0 ? kBright : 0);
    put(bytes, millimetres(range));
    put(bytes, 0);
  }
  unsigned sum = 0;
  for (const std::uint8_t byte : bytes) sum += byte;
  bytes.insert(bytes.end(), 2, static_cast<std::uint8_t>(0xFF - (sum & 0xFF)));
  return bytes;
}

Bytes camsense(const PacketContents& packet) {
  const auto angle = [](double degrees) { return 0xA000 + std::lround(64.0 * degrees) % (360 * 64); };
  Bytes bytes = {0x55, 0xAA, 0x03, 0x08};
  put(bytes, std::lround(3840.0 * packet.turn_rate));
  put(bytes, angle(packet.angles.front()));
  for (const double range : packet.ranges) {
    put(bytes, range > 0.0 ? millimetres(range) : 0x8000);
    bytes.push_back(range > 0.0 ? kBright : 0);
  }
  put(bytes, angle(packet.angles.back()));
  put(bytes, slam::neato::checkOf(bytes));
  return bytes;
}

constexpr PacketFormat slowYdlidar(const char* driver) {
  return {.driver = driver, .encode = ydlidarPlain, .shift = slam::ydlidar::shiftOf, .samples = 40, .turn_rate = 7.0};
}

constexpr std::array kFormats = {
    PacketFormat{.driver = "ld06", .encode = ldrobot},
    PacketFormat{.driver = "ld19", .encode = ldrobot},
    PacketFormat{.driver = "stl19p", .encode = ldrobot},
    PacketFormat{.driver = "stl27l", .encode = ldrobot},
    PacketFormat{.driver = "ms200", .encode = ldrobot},
    PacketFormat{.driver = "lds02", .encode = ldrobot, .shift = slam::ldrobot::ld08Shift, .turn_rate = 5.0},
    slowYdlidar("ydlidar-x2"),
    slowYdlidar("ydlidar-x4"),
    slowYdlidar("ydlidar-x4-pro"),
    PacketFormat{.driver = "ydlidar-g2", .encode = ydlidarBright, .shift = slam::ydlidar::shiftOf, .samples = 40},
    PacketFormat{.driver = "ydlidar-g4", .encode = ydlidarPlain, .shift = slam::ydlidar::shiftOf, .samples = 80},
    PacketFormat{.driver = "ydlidar-t-mini", .encode = ydlidarBright, .samples = 40},
    PacketFormat{.driver = "coin-d4", .encode = coin, .samples = 25, .turn_rate = 7.7},
    PacketFormat{.driver = "lds01", .encode = lds01, .samples = 6, .turn_rate = 5.0, .fixed = true},
    PacketFormat{.driver = "xv11", .encode = xv11, .samples = 4, .turn_rate = 5.0, .fixed = true},
    PacketFormat{.driver = "roborock", .encode = xv11, .samples = 4, .turn_rate = 5.0, .fixed = true},
    PacketFormat{.driver = "camsense-x1", .encode = camsense, .samples = 8, .turn_rate = 5.2},
};

/// A word of lidar.driver for several models, and the one that is played for it.
using Family = std::pair<std::string_view, std::string_view>;
constexpr std::array kFamilies = {Family{"ydlidar", "ydlidar-x4"}, Family{"lds", "lds02"},
                                  Family{"hokuyo", "hokuyo-urg"}, Family{"sick", "sick-tim"}};

}  // namespace

const PacketFormat* findPacketFormat(std::string_view driver) { return rowOfDriver<PacketFormat>(kFormats, driver); }

std::string_view lidarModel(std::string_view word) {
  const auto found = std::ranges::find(kFamilies, word, &Family::first);
  return found == kFamilies.end() ? word : found->second;
}

std::vector<std::string> lidarNames() {
  std::vector<std::string> names;
  for (const Family& family : kFamilies) names.emplace_back(family.first);
  for (const NamedIdentity& unit : namedIdentities()) names.push_back(unit.name);
  for (const PacketFormat& row : kFormats) names.push_back(row.driver);
  for (const ScipModel& model : scipModels()) names.push_back(model.name);
  for (const ColaModel& model : colaModels()) names.push_back(model.name);
  return names;
}

}  // namespace slam::sim
