// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/lidar/packet_lidar.hpp"

#include <cmath>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/pose2.hpp"
#include "drivers/lidar/packet_line.hpp"
#include "drivers/lidar/rplidar_unit.hpp"

namespace slam::packet_lidar_test {
namespace {

using namespace std::chrono_literals;
using test::PacketRig;
using test::virtual_now;
using testing::HasSubstr;

std::string nameOf(const testing::TestParamInfo<const char*>& test) {
  std::string name = test.param;
  std::erase(name, '-');
  return name;
}
std::vector<const char*> allDrivers() {
  std::vector<const char*> drivers;
  for (const LidarFacts& row : lidarTable()) drivers.push_back(row.driver);
  return drivers;
}

class PacketLidars : public testing::TestWithParam<const char*> {};

TEST_P(PacketLidars, GiveWholeTurnsOfTheRoom) {
  PacketRig rig(GetParam());
  ASSERT_TRUE(rig.connect()) << rig.words();
  ASSERT_TRUE(rig.collect(10)) << rig.words();
  EXPECT_EQ(rig.state(), DeviceState::kStreaming);
  EXPECT_EQ(rig.words(), "");
  EXPECT_THAT(std::string(rig.lidar.status().identity.load()), HasSubstr(rig.facts.name));
  const double turn_rate = sim::findPacketFormat(GetParam())->turn_rate;
  const double beams = rig.facts.sample_rate / turn_rate;
  for (const LaserScan& scan : rig.scans) {
    EXPECT_NEAR(scan.size, beams, 0.02 * beams);
    EXPECT_GE(scan.range_min, rig.facts.range.min);
    EXPECT_LE(scan.range_max, rig.facts.range.max);
    int wrong = 0;
    for (const Beam& beam : scan.beams()) {
      const bool at_edge = std::abs(std::abs(wrapAngle(beam.bearing)) - 1.57) < 0.05;
      wrong += !at_edge && beam.range > 0.0F && std::abs(beam.range - test::lidarRoom({}, beam.bearing)) > 0.005;
    }
    EXPECT_EQ(wrong, 0);
    EXPECT_NEAR(scan.beams().back().time_offset, 1.0 / turn_rate, 0.02 / turn_rate);
    EXPECT_GT(scan.stamp, virtual_now - 5s);
  }
  for (std::size_t i = 1; i < rig.scans.size(); ++i)
    EXPECT_NEAR(toSeconds(rig.scans[i].stamp - rig.scans[i - 1].stamp), 1.0 / turn_rate, 0.01);
}

TEST_P(PacketLidars, GoOnWhileBytesAreLostInsertedAndFlipped) {
  PacketRig rig(GetParam());
  ASSERT_TRUE(rig.connect());
  for (const char* fault : {"lose", "insert", "flip", "checksum"}) {
    ASSERT_TRUE(rig.emulator.inject(fault, 3.0));
    ASSERT_TRUE(rig.collect(5)) << fault << ": " << rig.words();
  }
  EXPECT_EQ(rig.words(), "");
  EXPECT_GT(rig.lidar.status().rejects.load(), 2);
}

TEST_P(PacketLidars, NameThePullOfThePlug) {
  PacketRig rig(GetParam());
  ASSERT_TRUE(rig.connect());
  ASSERT_TRUE(rig.collect(2));
  rig.line.unplug();
  EXPECT_LT(rig.pollUntilOver(), 1s);
  EXPECT_EQ(rig.state(), DeviceState::kAbsent);
  EXPECT_THAT(rig.words(), HasSubstr("unplugged"));
}

TEST_P(PacketLidars, NameTheirSilenceAndComeBack) {
  PacketRig rig(GetParam());
  ASSERT_TRUE(rig.connect());
  ASSERT_TRUE(rig.collect(2));
  ASSERT_TRUE(rig.emulator.inject("silent", 1.0));
  EXPECT_LT(rig.pollUntilOver(), 1s);
  EXPECT_EQ(rig.state(), DeviceState::kStale);
  EXPECT_THAT(rig.words(), testing::AllOf(HasSubstr("nothing comes"), HasSubstr("5 V")));
  EXPECT_FALSE(rig.connect());
  EXPECT_THAT(rig.words(), HasSubstr("check"));
  ASSERT_TRUE(rig.emulator.inject("silent", 0.0));
  const Timestamp back = virtual_now;
  ASSERT_TRUE(rig.connect()) << rig.words();
  ASSERT_TRUE(rig.collect(1));
  EXPECT_LT(virtual_now - back, 2s);
  EXPECT_EQ(rig.words(), "");
}

TEST_P(PacketLidars, NameBytesAmongWhichIsNoPacket) {
  PacketRig rig(GetParam());
  ASSERT_TRUE(rig.connect());
  ASSERT_TRUE(rig.collect(2));
  rig.garbled = true;
  EXPECT_LT(rig.pollUntilOver(), 1500ms);
  EXPECT_EQ(rig.state(), DeviceState::kStale);
  EXPECT_THAT(rig.words(), HasSubstr("no packet of this lidar"));
}

TEST_P(PacketLidars, NameTheRightBaudRate) {
  PacketRig rig(GetParam(), {}, 57600);
  EXPECT_FALSE(rig.connect());
  EXPECT_EQ(rig.state(), DeviceState::kFault);
  if (rig.facts.talk.start != nullptr) {  // it waits for a command that it cannot read
    EXPECT_THAT(rig.words(), HasSubstr("check baud rate"));
  } else {
    EXPECT_THAT(rig.words(), HasSubstr("set lidar.baud = " + std::to_string(rig.facts.baud)));
  }
}

TEST_P(PacketLidars, NameAHeadThatStands) {
  PacketRig rig(GetParam());
  ASSERT_TRUE(rig.connect());
  ASSERT_TRUE(rig.collect(2));
  ASSERT_TRUE(rig.emulator.inject("turn", 60000.0));
  EXPECT_LT(rig.pollUntilOver(), 4s);
  EXPECT_THAT(rig.words(), HasSubstr("turn"));
}

TEST_P(PacketLidars, GiveUpEarlyWhenCancelled) {
  PacketRig rig(GetParam());
  ASSERT_TRUE(rig.emulator.inject("silent", 1.0));
  rig.line.meanwhile = [&, at = virtual_now + 300ms] {
    if (virtual_now > at) rig.cancel = true;
  };
  const Timestamp begin = virtual_now;
  EXPECT_FALSE(rig.connect());
  EXPECT_LT(virtual_now - begin, 700ms);
  EXPECT_EQ(rig.state(), DeviceState::kAbsent);
}

INSTANTIATE_TEST_SUITE_P(Of, PacketLidars, testing::ValuesIn(allDrivers()), nameOf);

TEST(PacketLidar, OutlivesTheWrapOfItsClock) {
  PacketRig rig("ld19");
  rig.emulator.setUptime(29s);  // its stamps begin anew at 30 s
  ASSERT_TRUE(rig.connect());
  ASSERT_TRUE(rig.collect(20)) << rig.words();
  EXPECT_EQ(rig.lidar.status().rejects.load(), 0);
  for (std::size_t i = 1; i < rig.scans.size(); ++i)
    EXPECT_NEAR(toSeconds(rig.scans[i].stamp - rig.scans[i - 1].stamp), 0.1, 0.005);
}

TEST(PacketLidar, IsNamedWhereAnRplidarIsConfigured) {
  PacketRig rig("ld19");
  std::atomic<bool> cancel{false};
  SerialLidar rplidar(
      {.port = "x"}, std::make_unique<RplidarUnit>(RplidarConfig{}, test::virtualNow), test::virtualNow,
      [](const LaserScan&) {},
      [&](const std::string& path, int baud) {
        rig.garbled = baud != 230400;
        return rig.line.opener()(path, baud);
      });
  EXPECT_FALSE(rplidar.connect(cancel));
  EXPECT_THAT(rplidar.status().problem().words(),
              testing::AllOf(HasSubstr("LDROBOT"), HasSubstr("lidar.driver = ld06")));
}

}  // namespace
}  // namespace slam::packet_lidar_test
