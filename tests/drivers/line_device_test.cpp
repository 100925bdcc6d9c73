// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/line_device.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <random>

#include "drivers/lidar/lidar_line.hpp"
#include "drivers/lidar/rplidar.hpp"
#include "firmware_if/create_oi.hpp"
#include "firmware_if/hfi_imu.hpp"
#include "firmware_if/kobuki.hpp"
#include "firmware_if/robolink.hpp"
#include "support/problems.hpp"
#include "tools/sim/imu/emulated_imu.hpp"
#include "tools/sim/lidar/other_lidar.hpp"

namespace slam::line_device_test {
namespace {

using namespace std::chrono_literals;
using test::Bytes;
using test::virtual_now;
using testing::AllOf;
using testing::HasSubstr;

Bytes otherLidar(sim::OtherLidar::Make make) {
  sim::OtherLidar lidar;
  Bytes bytes;
  for (Timestamp now{10s}; bytes.size() < 1500; now += 10ms)
    lidar.stream(
        make, now, [](double bearing) { return 2.0 + bearing; }, bytes);
  bytes.erase(bytes.begin(), bytes.begin() + 13);  // one listens from any byte on
  return bytes;
}

Bytes boardAnswer() {
  Bytes bytes(robolink::kMaxFrame);
  bytes.resize(robolink::encodeFrame(robolink::kSlave, robolink::kMaster, robolink::Command::kShakingHands, {}, bytes));
  return bytes;
}

Bytes imuStream() {
  Bytes bytes;
  for (int i = 0; i < 10; ++i) {
    const auto frame = hfi::encodeA9(hfi::A9Motion{.gyro = {0.01F * static_cast<float>(i), 0, 0}, .accel = {0, 0, -1}});
    bytes.insert(bytes.end(), frame.begin(), frame.end());
  }
  return bytes;
}

Bytes streamOf(std::string_view imu) {
  const auto unit = sim::makeImu(imu);
  Bytes bytes;
  for (int i = 0; i < 5; ++i) unit->sample({0.01 * i, 0.0, 0.2}, {0.0, 0.0, 9.8}, bytes);
  bytes.erase(bytes.begin(), bytes.begin() + 5);  // one listens from any byte on
  return bytes;
}

TEST(LineDevice, IsNobodyInNoise) {
  std::mt19937 random(9);
  for (int i = 0; i < 300; ++i) {
    Bytes bytes(1 + random() % 2000);
    for (auto& byte : bytes) byte = static_cast<std::uint8_t>(random());
    EXPECT_EQ(lineDeviceOf(bytes).line_device, LineDevice::kUnknown);
  }
  EXPECT_EQ(lineDeviceOf({}).line_device, LineDevice::kUnknown);
  EXPECT_EQ(lineDeviceOf(Bytes(2000, 0x55)).line_device, LineDevice::kUnknown) << "a line that is held";
  EXPECT_EQ(lineDeviceOf(Bytes(2000, 0)).line_device, LineDevice::kUnknown);
}

TEST(LineDevice, IsKnownByItsFrames) {
  EXPECT_EQ(lineDeviceOf(Bytes{0x00, 0xA5, 0x5A, 0x14, 0, 0, 0, 0x04, 24, 1, 2}).line_device, LineDevice::kRplidar);
  EXPECT_EQ(lineDeviceOf(boardAnswer()).line_device, LineDevice::kBoard);
  EXPECT_EQ(lineDeviceOf(imuStream()).line_device, LineDevice::kImu) << "AA 55 too, but not YDLIDAR's";
  EXPECT_EQ(lineDeviceOf(streamOf("bno08x")).line_device, LineDevice::kBno08x) << "AA AA, and no packet of a lidar";
  EXPECT_EQ(lineDeviceOf(streamOf("witmotion")).line_device, LineDevice::kWitmotion);
  EXPECT_EQ(lineDeviceOf(streamOf("xsens")).line_device, LineDevice::kXsens) << "FA, and not Neato's";
  EXPECT_EQ(lineDeviceOf(otherLidar(sim::OtherLidar::kLdrobot)).line_device, LineDevice::kLdrobot);
  EXPECT_EQ(lineDeviceOf(otherLidar(sim::OtherLidar::kYdlidar)).line_device, LineDevice::kYdlidar);
  EXPECT_EQ(lineDeviceOf(otherLidar(sim::OtherLidar::kNeato)).line_device, LineDevice::kNeato);
  const auto repeated = [](const Outgoing& frame) {
    Bytes bytes{0xAA, 0x13};
    for (int i = 0; i < 5; ++i) bytes.insert(bytes.end(), frame.bytes().begin(), frame.bytes().end());
    return bytes;
  };
  EXPECT_EQ(lineDeviceOf(repeated(kobuki::encodeFeedback({.stamp = 7}))).line_device, LineDevice::kKobuki)
      << "AA 55 as well";
  EXPECT_EQ(lineDeviceOf(repeated(create_oi::encodeStream({.voltage = 14000}))).line_device, LineDevice::kCreate);
  for (const std::string line : {"57600\r\n", "Invalid Command\r\n"})
    EXPECT_EQ(lineDeviceOf(Bytes(line.begin(), line.end())).line_device, LineDevice::kArduino) << line;
  const std::string gps = "$GPGGA,123519,4807.038,N,01131.000,E,1,08,0.9,545.4,M,46.9,M,,*47\r\n";
  EXPECT_EQ(lineDeviceOf(Bytes(gps.begin(), gps.end())).line_device, LineDevice::kGps);
}

TEST(LineDevice, OfUnknownMakeIsKnownByItsHeader) {
  std::mt19937 random(2);
  Bytes bytes(17);
  for (int i = 0; i < 30; ++i) {
    bytes.insert(bytes.end(), {0xC3, 0x51});
    for (int k = 0; k < 29; ++k) bytes.push_back(static_cast<std::uint8_t>(random()));
  }
  const RecognisedDevice found = lineDeviceOf(bytes);
  EXPECT_EQ(found.line_device, LineDevice::kPackets);
  EXPECT_THAT(found.header, testing::ElementsAre(0xC3, 0x51));
}

/// A device on a line at a baud rate of its own: at another it is not understood.
struct Device {
  int baud;
  std::function<Bytes(const Bytes& question)> answer;
  int line_baud = 0, openings = 0;
  Bytes out{}, in{};
  test::VirtualLine line{[this](std::span<const std::uint8_t> bytes) {
                           in.assign(bytes.begin(), bytes.end());
                           const Bytes said = answer(in);
                           out.insert(out.end(), said.begin(), said.end());
                         },
                         [this](Bytes& sent) {
                           for (const std::uint8_t byte : std::exchange(out, {}))
                             sent.push_back(line_baud == baud ? byte : static_cast<std::uint8_t>(byte * 7 + 3));
                         }};

  PortOpener opener() {
    return [this](const std::string& path, int at) {
      line_baud = at;
      ++openings;
      return line.opener()(path, at);
    };
  }
};

std::string wordsOf(Device& device, PortOf expected, int baud) {
  WrongDevice wrong(expected, "/dev/x", baud, device.opener());
  wrong.ask();
  while (wrong.tick(virtual_now)) wrong.rest(10ms);
  return wrong.found(test::problemOf("not known")).words();
}

TEST(WrongDevice, NamesSwappedPorts) {
  Device board{921600, [](const Bytes& question) {
                 return question.size() > 6 && question[0] == 0xFF && question[6] == 1 ? boardAnswer() : Bytes{};
               }};
  EXPECT_THAT(wordsOf(board, PortOf::kLidar, 115200),
              AllOf(HasSubstr("the HandsFree board is on this port"), HasSubstr("exchange lidar.port and base.port")));
  Device lidar{256000, [](const Bytes& question) {
                 return question == Bytes{0xA5, 0x50} ? Bytes{0xA5, 0x5A, 0x14, 0, 0, 0, 4, 24} : Bytes{};
               }};
  EXPECT_THAT(wordsOf(lidar, PortOf::kBoard, 921600),
              AllOf(HasSubstr("an RPLidar is on this port"), HasSubstr("exchange base.port and lidar.port")));
  EXPECT_THAT(wordsOf(lidar, PortOf::kImu, 921600), HasSubstr("exchange imu.port and lidar.port"));
}

TEST(WrongDevice, NamesTheRightBaudRate) {
  Device lidar{460800, [](const Bytes& question) {
                 return question == Bytes{0xA5, 0x50} ? Bytes{0xA5, 0x5A, 0x14, 0, 0, 0, 4, 24} : Bytes{};
               }};
  EXPECT_THAT(wordsOf(lidar, PortOf::kLidar, 115200), HasSubstr("set lidar.baud = 460800"));
  EXPECT_EQ(wordsOf(lidar, PortOf::kLidar, 460800), "not known") << "it is the right one";
}

TEST(WrongDevice, AsksOnceUntilItIsToForget) {
  Device nobody{115200, [](const Bytes&) { return Bytes{}; }};
  WrongDevice wrong(PortOf::kLidar, "/dev/x", 115200, nobody.opener());
  const auto ask = [&] {
    wrong.ask();
    while (wrong.tick(virtual_now)) wrong.rest(10ms);
    return nobody.openings;
  };
  const int once = ask();
  EXPECT_EQ(once, 9) << "each baud rate once";
  EXPECT_EQ(ask(), once);
  EXPECT_EQ(wrong.found(test::problemOf("not known")).words(), "not known");
  wrong.forget();
  EXPECT_EQ(ask(), 2 * once);
}

TEST(WrongDevice, EndsWhenThePortGoes) {
  Device nobody{115200, [](const Bytes&) { return Bytes{}; }};
  WrongDevice wrong(PortOf::kLidar, "/dev/x", 115200, nobody.opener());
  wrong.ask();
  nobody.line.unplug();
  EXPECT_FALSE(wrong.tick(virtual_now));
  EXPECT_FALSE(wrong.running());
}

TEST(RplidarWrongPort, NamesAnotherMakesLidarAndGoesOnWhenItsOwnIsThere) {
  for (const auto& [make, words] : {std::pair(1.0, "LDROBOT"), {2.0, "YDLIDAR"}, {3.0, "Neato"}}) {
    SCOPED_TRACE(words);
    test::VirtualLidar lidar(sim::a1Firmware129());
    int scans = 0;
    std::atomic<bool> cancel{false};
    test::Rplidar driver(
        "x", {}, test::virtualNow, [&](const LaserScan&) { ++scans; }, lidar.line().opener());
    ASSERT_TRUE(lidar.inject("other", make));
    EXPECT_FALSE(driver.connect(cancel));
    EXPECT_THAT(driver.status().problem().words(),
                AllOf(HasSubstr(words), HasSubstr("a lidar"), HasSubstr("set lidar.driver = ")));
    EXPECT_EQ(driver.status().state, DeviceState::kFault);
    const Timestamp again = virtual_now;
    EXPECT_FALSE(driver.connect(cancel));
    EXPECT_LT(virtual_now - again, 7s);
    EXPECT_THAT(driver.status().problem().words(), HasSubstr(words)) << "said as long as it is there";
    ASSERT_TRUE(lidar.inject("other", 0.0));
    ASSERT_TRUE(driver.connect(cancel)) << driver.status().problem().words();
    for (const Timestamp end = virtual_now + 5s; virtual_now < end;) driver.poll(50ms);
    EXPECT_GT(scans, 10);
    EXPECT_EQ(driver.status().problem().words(), "");
  }
}

}  // namespace
}  // namespace slam::line_device_test
