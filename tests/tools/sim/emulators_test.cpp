// SPDX-License-Identifier: BSD-3-Clause
#include <array>
#include <cmath>
#include <gtest/gtest.h>
#include <numbers>

#include "core/pose2.hpp"
#include "drivers/lidar/codec/rplidar_codec.hpp"
#include "drivers/lidar/rplidar_stream.hpp"
#include "tools/sim/board/board_emulator.hpp"
#include "tools/sim/lidar/lidar_emulator.hpp"

namespace slam::sim::emulators_test {
namespace {

using namespace std::chrono_literals;
constexpr Timestamp kStart{100s};
using Bytes = std::vector<std::uint8_t>;

/// A round room with a dent: 2 m, but 1 m from 60 to 90 degrees counter-clockwise.
double dent(Timestamp, double bearing) {
  const double degrees = wrapAngle(bearing) * 180.0 / std::numbers::pi;
  return degrees > 60.0 && degrees < 90.0 ? 1.0 : 2.0;
}

TEST(LidarEmulator, AnswersInfoAndHealthByteForByte) {
  LidarEmulator lidar(dent, 5.5);
  Bytes out;
  lidar.receive(rplidar::encodeRequest(rplidar::Request::kGetHealth), kStart, out);
  EXPECT_EQ(out, (Bytes{0xA5, 0x5A, 3, 0, 0, 0, 6, 0, 0, 0}));
  out.clear();
  lidar.receive(rplidar::encodeRequest(rplidar::Request::kGetInfo), kStart, out);
  ASSERT_EQ(out.size(), 27U);
  const auto info = rplidar::parseInfo({out.data() + 7, 20});
  ASSERT_TRUE(info);
  EXPECT_EQ(info->model, 0x18);
  EXPECT_EQ(info->firmware, 0x011D);
}

class LidarEmulatorScan : public testing::TestWithParam<rplidar::AnswerType> {};

TEST_P(LidarEmulatorScan, PutsTheDentWhereItIsAndPacesItsBytes) {
  const bool express = GetParam() == rplidar::AnswerType::kExpressCapsules;
  LidarEmulator lidar(dent, 5.5);
  Bytes out;
  lidar.receive(express ? rplidar::encodeExpressScan() : rplidar::encodeRequest(rplidar::Request::kScan), kStart, out);
  ASSERT_EQ(out.size(), rplidar::kDescriptorSize);
  out.clear();
  for (int ms = 0; ms <= 2000; ms += 2) lidar.stream(kStart + std::chrono::milliseconds(ms), out);
  EXPECT_LE(out.size(), 2U * 11520U);  // the line carries no more

  rplidar::StreamDecoder decoder(GetParam(), express ? 254e-6 : 508e-6, 10.0 / 115200);
  std::vector<TimedNode> nodes;
  for (const std::uint8_t byte : out) decoder.push(byte, nodes);
  int turns = 0, wrong = 0;
  for (const auto& [node, age] : nodes) {
    turns += node.start;
    const double bearing = -node.angle_q6 / 64.0;  // [deg] clockwise there
    const double expected = wrapAngle(bearing * std::numbers::pi / 180.0) * 180.0 / std::numbers::pi;
    const bool edge = std::abs(expected - 60.0) < 1.0 || std::abs(expected - 90.0) < 1.0;
    const double range = node.distance_q2 * 0.25e-3;
    if (!edge && std::abs(range - dent({}, bearing * std::numbers::pi / 180.0)) > 0.002) ++wrong;
  }
  EXPECT_NEAR(turns, 11, 1);
  EXPECT_EQ(wrong, 0);
  EXPECT_EQ(decoder.counters().bad_checksums + decoder.counters().bad_check_bits, 0U);
}

INSTANTIATE_TEST_SUITE_P(Modes, LidarEmulatorScan,
                         testing::Values(rplidar::AnswerType::kStandardNodes, rplidar::AnswerType::kExpressCapsules));

TEST(BoardEmulator, AsksForTheHandshakeAndThenAnswers) {
  BoardEmulator board;
  board.renew(1.5, 2.5, {.gyro = {0.0F, 0.0F, 0.25F}, .accel = {0.0F, 0.0F, 9.8F}}, 3.0);
  const Bytes ask_mileage = {0xFF, 0xFF, 0x01, 0x11, 0x00, 0x01, 0x10, 0x23};
  Bytes out;
  board.receive(ask_mileage, out);
  EXPECT_EQ(out, (Bytes{0xFF, 0xFF, 0x11, 0x01, 0x00, 0x01, 0x00, 0x13}));
  Bytes shake = {0xFF, 0xFF, 0x01, 0x11, 0x00, 0x0D, 0x00};
  shake.resize(shake.size() + 12, 0x00);
  shake.push_back(0x1F);
  out.clear();
  board.receive(shake, out);
  EXPECT_TRUE(out.empty());  // stored, not acknowledged
  board.receive(ask_mileage, out);
  robolink::Decoder decoder;
  std::optional<robolink::Frame> frame;
  for (const std::uint8_t byte : out) {
    if (auto found = decoder.push(byte)) frame = found;
  }
  ASSERT_TRUE(frame);
  const auto mileage = robolink::parseMotorVector(frame->payload);
  ASSERT_TRUE(mileage);
  EXPECT_FLOAT_EQ((*mileage)[0], -1.5F);  // the left motor counts backwards
  EXPECT_FLOAT_EQ((*mileage)[1], 2.5F);
}

}  // namespace
}  // namespace slam::sim::emulators_test
