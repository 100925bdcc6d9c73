// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/lidar/lidar_facts.hpp"

#include <array>
#include <cstdio>

#include "drivers/lidar/codec/ldrobot_packets.hpp"
#include "drivers/lidar/codec/neato_packets.hpp"
#include "drivers/lidar/codec/ydlidar_packets.hpp"
#include "drivers/search/driver_row.hpp"

namespace slam {
namespace {

using namespace std::chrono_literals;
using Answer = LidarTalk::Answer;
using rplidar::AnswerType;

constexpr Duration kAnswer = 300ms;  // to a question
constexpr Duration kQuiet = 50ms;    // after a scan was stopped

template <std::size_t Size>
void send(ByteStream& port, const std::array<std::uint8_t, Size>& bytes) {
  port.write(bytes);
}

constexpr std::array<std::uint8_t, 2> kYdForceStop = {0xA5, 0x00}, kYdStop = {0xA5, 0x65}, kYdScan = {0xA5, 0x60},
                                      kYdInfo = {0xA5, 0x90}, kYdHealth = {0xA5, 0x92};

void stopYdlidar(ByteStream& port) {
  send(port, kYdForceStop);
  port.rest(5ms);
  send(port, kYdStop);
  port.rest(5ms);
}

/// Asks in the order that an X4 needs: info, health, stop, scan. A unit that does not answer may scan all the same.
Answer startYdlidar(rplidar::Dialogue& dialogue) {
  dialogue.send(kYdForceStop);
  dialogue.drain(kQuiet, 10 * kQuiet);
  dialogue.send(kYdStop);
  dialogue.drain(kQuiet, 10 * kQuiet);
  Answer answer;
  // Model, firmware minor and major, hardware, serial number in one decimal digit a byte.
  if (const auto info = dialogue.ask(kYdInfo, AnswerType::kInfo, 20, kAnswer); !info.empty()) {
    std::array<char, 64> text{};
    std::snprintf(text.data(), text.size(), " (model %d), firmware %d.%d, hardware %d, serial number ", info[0],
                  info[2], info[1], info[3]);
    answer.identity = text.data();
    for (std::size_t i = 4; i < info.size(); ++i) answer.identity += static_cast<char>('0' + info[i] % 10);
  }
  if (const auto health = dialogue.ask(kYdHealth, AnswerType::kHealth, 3, kAnswer); !health.empty()) {
    answer.fault = health[0] == 2;
    if (health[0] == 1) answer.problem = problem::kLidarWarns;
    if (health[0] == 2) answer.problem = problem::kLidarErrorStays;
  }
  dialogue.send(kYdScan);
  return answer;
}

constexpr std::array<std::uint8_t, 4> kCoinStart = {0xAA, 0x55, 0xF0, 0x0F}, kCoinStop = {0xAA, 0x55, 0xF5, 0x0A};

Answer startCoin(rplidar::Dialogue& dialogue) {
  dialogue.send(kCoinStart);
  return {};
}
void stopCoin(ByteStream& port) { send(port, kCoinStop); }

Answer startLds01(rplidar::Dialogue& dialogue) {
  dialogue.send(std::array<std::uint8_t, 1>{'b'});
  return {};
}
void stopLds01(ByteStream& port) { send(port, std::array<std::uint8_t, 1>{'e'}); }

constexpr LidarTalk kYdTalk{startYdlidar, stopYdlidar}, kCoinTalk{startCoin, stopCoin},
    kLds01Talk{startLds01, stopLds01};

// Figures of the makers' drivers; the ranges are narrowed by lidar.range_min and lidar.range_max.
constexpr LidarFacts asked(const LidarTalk& talk, LidarFacts row, bool motor_by_dtr = false) {
  row.talk = talk;
  row.motor_by_dtr = motor_by_dtr;
  return row;
}

using enum LineDevice;
constexpr std::array kTable = {
    LidarFacts{"ld06", "LDROBOT LD06", kLdrobot, &ldrobot::kPackets, 230400, 4500.0, {0.02F, 12.0F}},
    LidarFacts{"ld19", "LDROBOT LD19", kLdrobot, &ldrobot::kPackets, 230400, 4500.0, {0.02F, 12.0F}},
    LidarFacts{"stl19p", "LDROBOT STL-19P", kLdrobot, &ldrobot::kPackets, 230400, 5000.0, {0.02F, 12.0F}},
    LidarFacts{"stl27l", "LDROBOT STL-27L", kLdrobot, &ldrobot::kPackets, 921600, 21600.0, {0.03F, 25.0F}},
    LidarFacts{"ms200", "Oradar MS200", kLdrobot, &ldrobot::kPackets, 230400, 4500.0, {0.03F, 12.0F}},
    LidarFacts{"lds02", "TurtleBot3 LDS-02", kLdrobot, &ldrobot::kLd08Packets, 115200, 2300.0, {0.16F, 8.0F}},
    asked({}, {"ydlidar-x2", "YDLIDAR X2", kYdlidar, &ydlidar::kPlainPackets, 115200, 3000.0, {0.1F, 8.0F}}, true),
    asked(kYdTalk, {"ydlidar-x4", "YDLIDAR X4", kYdlidar, &ydlidar::kPlainPackets, 128000, 5000.0, {0.12F, 10.0F}},
          true),
    LidarFacts{"ydlidar-x4-pro", "YDLIDAR X4 Pro", kYdlidar, &ydlidar::kPlainPackets, 128000, 5000.0, {0.12F, 10.0F}},
    asked(kYdTalk, {"ydlidar-g2", "YDLIDAR G2", kYdlidar, &ydlidar::kBrightPackets, 230400, 5000.0, {0.28F, 16.0F}}),
    asked(kYdTalk, {"ydlidar-g4", "YDLIDAR G4", kYdlidar, &ydlidar::kPlainPackets, 230400, 9000.0, {0.28F, 16.0F}}),
    asked(
        kYdTalk,
        {"ydlidar-t-mini", "YDLIDAR T-mini", kYdlidar, &ydlidar::kTimeOfFlightPackets, 230400, 4000.0, {0.05F, 12.0F}}),
    // Its sample rate stands in no source; the angles of a recorded packet fit 5000 at 7.7 turns a second.
    asked(kCoinTalk, {"coin-d4", "COIN-D4 (LDS-03)", kYdlidar, &ydlidar::kCoinPackets, 230400, 5000.0, {0.1F, 12.0F}}),
    // Its angles rise clockwise by its maker's driver; another source has it otherwise.
    asked(kLds01Talk, {"lds01", "TurtleBot3 LDS-01", kNeato, &neato::kLds01Packets, 230400, 1800.0, {0.12F, 3.5F}}),
    LidarFacts{"xv11", "Neato XV-11", kNeato, &neato::kXv11Packets, 115200, 1800.0, {0.15F, 6.0F}, false},
    LidarFacts{"roborock", "Roborock LDS02RR", kNeato, &neato::kXv11Packets, 115200, 1800.0, {0.15F, 6.0F}},
    LidarFacts{"camsense-x1", "Camsense X1", kCamsense, &neato::kCamsensePackets, 115200, 2080.0, {0.1F, 8.0F}},
};

}  // namespace

std::span<const LidarFacts> lidarTable() { return kTable; }

const LidarFacts* findLidar(std::string_view driver) { return rowOfDriver(lidarTable(), driver); }

}  // namespace slam
