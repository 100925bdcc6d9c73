// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/search/port_search.hpp"

#include <gtest/gtest.h>
#include <random>

#include "drivers/base/base_rig.hpp"
#include "drivers/imu/imu_rig.hpp"
#include "drivers/lidar/lidar_line.hpp"
#include "drivers/search/driver_row.hpp"
#include "drivers/virtual_line.hpp"
#include "tools/sim/lidar/lidar_emulator.hpp"
#include "tools/sim/lidar/lidar_model.hpp"
#include "tools/sim/lidar/packet_emulator.hpp"

namespace slam::port_search_test {
namespace {

using test::Bytes;
using test::virtual_now;

/// A port whose device is understood at one baud rate alone.
class Port {
 public:
  using Send = std::function<void(Bytes&)>;

  Port(int baud, test::VirtualLine::Receive receive, Send send)
      : baud_(baud),
        line_(
            [this, receive](std::span<const std::uint8_t> bytes) {
              sent.insert(sent.end(), bytes.begin(), bytes.end());
              if (!garbled_) receive(bytes);
            },
            [this, send](Bytes& out) {
              Bytes bytes;
              send(bytes);
              for (const std::uint8_t byte : bytes) {
                if (!garbled_) out.push_back(byte);
                if (garbled_ && random_() % 2 == 0) out.push_back(static_cast<std::uint8_t>(random_()));
              }
            }) {}
  PortFinding find() {
    const std::atomic<bool> cancel{false};
    const auto open = [this](const std::string& path, int baud) {
      garbled_ = baud_ > 0 && baud != baud_;
      return line_.opener()(path, baud);
    };
    return PortSearch("/dev/x", open, test::virtualNow).find(cancel);
  }

  Bytes sent;

 private:
  int baud_;
  bool garbled_ = false;
  std::mt19937 random_{1};
  test::VirtualLine line_;
};

/// @param deaf to what comes within that time: it boots
PortFinding findBaseOf(const std::string& driver, int baud, Duration deaf = Duration(0)) {
  const auto emulator = sim::makeBase(driver);
  sim::RobotModel robot({}, 1, sim::geometryOf(driver).base);
  Bytes answers;
  Port port(
      baud,
      [&, end = virtual_now + deaf](std::span<const std::uint8_t> bytes) {
        if (virtual_now >= end) emulator->exchange(bytes, virtual_now, answers);
      },
      [&](Bytes& out) {
        emulator->renew(robot, virtual_now);
        emulator->exchange({}, virtual_now, answers);
        out = std::exchange(answers, {});
      });
  const PortFinding found = port.find();
  EXPECT_EQ(emulator->drive().vx, 0.0) << "no motor moves";
  EXPECT_EQ(emulator->drive().omega, 0.0);
  return found;
}

TEST(PortSearch, FindsEachBase) {
  for (const std::string& driver : sim::baseNames()) {
    SCOPED_TRACE(driver);
    const BaseFacts* facts = findBase(driver);
    const PortFinding found = findBaseOf(driver, facts == nullptr ? 921600 : facts->baud);
    EXPECT_EQ(found.kind, PortFinding::kBase) << found.name << found.problem.words();
    EXPECT_EQ(found.driver, driver);
    EXPECT_TRUE(found.is_usual_baud);
  }
  const PortFinding faster = findBaseOf("text", 115200);
  EXPECT_EQ(faster.driver, "text");
  EXPECT_EQ(faster.baud, 115200);
  EXPECT_FALSE(faster.is_usual_baud) << "base.baud is to be set";
  EXPECT_TRUE(findBaseOf("kobuki", 0).is_usual_baud) << "on a line that carries any rate";
  EXPECT_EQ(findBaseOf("handsfree", 921600, std::chrono::seconds(5)).driver, "handsfree") << "asked again";
}

TEST(PortSearch, FindsEachImuAtEachBaudRate) {
  for (const ImuFacts& facts : imuTable()) {
    SCOPED_TRACE(facts.driver);
    for (std::size_t i = 0; i < facts.baudCount(); ++i) {
      const auto emulator = sim::makeImu(facts.driver);
      Timestamp next = virtual_now;
      Port port(
          facts.bauds[i], [](auto) {},
          [&](Bytes& out) {
            for (; next <= virtual_now; next += sim::EmulatedImu::kPeriod)
              emulator->sample({0.001 * toSeconds(next.time_since_epoch()), 0.0, 0.0}, {0.0, 0.0, 9.8}, out);
          });
      const PortFinding found = port.find();
      EXPECT_EQ(found.kind, PortFinding::kImu) << found.name << " " << facts.bauds[i];
      EXPECT_EQ(found.driver, facts.driver);
      EXPECT_EQ(found.baud, facts.bauds[i]);
    }
  }
}

TEST(PortSearch, FindsEachLidarThatSendsOrAnswers) {
  const auto find = [](sim::EmulatedLidar& device, int baud) {
    Bytes answers;
    Port port(
        baud, [&](std::span<const std::uint8_t> bytes) { device.receive(bytes, virtual_now, answers); },
        [&](Bytes& out) {
          device.stream(virtual_now, answers);
          out = std::exchange(answers, {});
        });
    return port.find();
  };
  for (const LidarFacts& row : lidarTable()) {
    sim::PacketEmulator device(test::lidarRoom, row.driver);
    const PortFinding found = find(device, row.baud);
    EXPECT_EQ(found.kind, PortFinding::kLidar) << row.driver << ": " << found.problem.words();
    const LidarFacts* as = findLidar(found.driver);
    ASSERT_NE(as, nullptr) << row.driver;
    EXPECT_EQ(as->packets, row.packets) << row.driver;
    EXPECT_TRUE(found.is_usual_baud);
  }
  for (const sim::NamedIdentity& unit : sim::namedIdentities()) {
    sim::LidarEmulator device(test::lidarRoom, unit.make().turn_rate, unit.make());
    const PortFinding found = find(device, unit.make().baud);
    EXPECT_EQ(found.driver, "rplidar") << unit.name << ": " << found.problem.words();
    EXPECT_EQ(found.is_usual_baud, unit.make().baud == 115200);
  }
}

TEST(PortSearch, FindsAnXsensThatIsBeingConfigured) {
  const auto emulator = sim::makeImu("xsens");
  emulator->inject("config", 1.0);
  Bytes answers;
  Port port(
      115200, [&](std::span<const std::uint8_t> bytes) { emulator->receive(bytes, answers); },
      [&](Bytes& out) { out = std::exchange(answers, {}); });
  const PortFinding found = port.find();
  EXPECT_EQ(found.kind, PortFinding::kImu) << found.name << found.problem.words();
  EXPECT_EQ(found.driver, "xsens");
  EXPECT_EQ(std::find(port.sent.begin(), port.sent.end(), 0xA5), port.sent.end()) << "no lidar is asked before it";
}

TEST(PortSearch, StartsTheLidarsThatWaitForItLastAndStopsThem) {
  for (const char* driver : {"coin-d4", "lds01"}) {
    sim::PacketEmulator device(test::lidarRoom, driver);
    Bytes answers;
    const auto receive = [&](std::span<const std::uint8_t> bytes) { device.receive(bytes, virtual_now, answers); };
    const auto send = [&](Bytes& out) {
      device.stream(virtual_now, answers);
      out = std::exchange(answers, {});
    };
    Port port(230400, receive, send);
    EXPECT_EQ(port.find().driver, driver);
    Bytes after;
    send(after);
    after.clear();
    virtual_now += std::chrono::seconds(1);
    send(after);
    EXPECT_TRUE(after.empty()) << driver << " turns no more";
    const auto start = std::find(port.sent.begin(), port.sent.end(), driver == std::string_view("lds01") ? 'b' : 0xF0);
    const auto arduino = std::find(port.sent.begin(), port.sent.end(), 'e');
    EXPECT_LT(arduino, start) << "it is asked first";
  }
}

TEST(PortSearch, AsksASilentPortForACreateBeforeALidarAndNothingThatMovesOrStarts) {
  Port port(
      0, [](auto) {}, [](Bytes&) {});
  const PortFinding found = port.find();
  EXPECT_EQ(found.kind, PortFinding::kNothing);
  EXPECT_TRUE(found.problem.is(problem::kLidarUnheard));
  const auto lidars = std::find(port.sent.begin(), port.sent.end(), 0xA5);
  EXPECT_NE(std::find(port.sent.begin(), lidars, 0x80), lidars) << "a Create is asked first";
  EXPECT_NE(std::find(port.sent.begin(), lidars, 0xAD), lidars) << "and is off again, should its answer be lost";
  for (std::size_t i = 0; i + 1 < port.sent.size(); ++i) {
    const int byte = port.sent[i], next = port.sent[i + 1];
    if (byte == 0xA5) {
      EXPECT_TRUE(next == 0x50 || next == 0x90) << "neither reset, nor stop, nor start";
    }
    EXPECT_FALSE(byte == 'm') << "an Arduino's wheels";
    EXPECT_FALSE(byte == 'b' && i + 2 < port.sent.size()) << "starts an LDS-01: last of all, but for its stop";
    EXPECT_FALSE(byte == 137 || byte == 145 || byte == 135) << "drives or cleans";
  }
}

TEST(PortSearch, AsksAnUnknownSenderNothingThatItsFramesForbid) {
  const std::string gps = "$GPGGA,123519,4807.038,N,01131.000,E,1,08,0.9,545.4,M,46.9,M,,*47\r\n";
  Port port(
      115200, [](auto) {}, [&](Bytes& out) { out.insert(out.end(), gps.begin(), gps.end()); });
  const PortFinding found = port.find();
  EXPECT_EQ(found.kind, PortFinding::kForeign);
  EXPECT_EQ(found.name, "a GPS receiver");
  EXPECT_TRUE(port.sent.empty());
}

TEST(DriverRow, IsFoundByWordAndByLineDevice) {
  EXPECT_EQ(rowOfDriver(baseTable(), "none"), nullptr);
  EXPECT_STREQ(rowOfDriver(baseTable(), "kobuki")->name, "a Kobuki");
  EXPECT_STREQ(rowOfLineDevice(imuTable(), LineDevice::kXsens)->driver, "xsens");
  EXPECT_EQ(rowOfLineDevice(imuTable(), LineDevice::kGps), nullptr);
}

}  // namespace
}  // namespace slam::port_search_test
