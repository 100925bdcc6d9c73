// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/lidar/search/lidar_search.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <memory>
#include <random>

#include "drivers/lidar/lidar_line.hpp"
#include "drivers/lidar/packet_lidar.hpp"
#include "drivers/lidar/serial_lidar.hpp"
#include "drivers/virtual_line.hpp"
#include "tools/sim/lidar/cola_emulator.hpp"
#include "tools/sim/lidar/packet_emulator.hpp"
#include "tools/sim/lidar/packet_encoders.hpp"
#include "tools/sim/lidar/scip_emulator.hpp"

namespace slam::lidar_search_test {
namespace {

using namespace std::chrono_literals;
using test::Bytes;
using test::virtual_now;
using testing::HasSubstr;

/// A device that understands and is understood at one baud rate alone. 0: at any, as on USB.
class Port {
 public:
  Port(std::unique_ptr<sim::EmulatedLidar> device, int baud)
      : device_(std::move(device)),
        baud_(baud),
        line_(
            [this](std::span<const std::uint8_t> bytes) {
              sent_.insert(sent_.end(), bytes.begin(), bytes.end());
              if (device_ && !garbled_) device_->receive(bytes, virtual_now, answers_);
            },
            [this](Bytes& out) {
              if (device_) device_->stream(virtual_now, answers_);
              for (const std::uint8_t byte : std::exchange(answers_, {})) {
                if (!garbled_) out.push_back(byte);
                if (garbled_ && random_() % 2 == 0) out.push_back(static_cast<std::uint8_t>(random_()));
              }
              if (always != nullptr) out.insert(out.end(), always, always + std::char_traits<char>::length(always));
            }) {}

  PortOpener opener() {
    return [this](const std::string& path, int baud) {
      garbled_ = baud_ > 0 && baud != baud_;
      ++opened_;
      return line_.opener()(path, baud);
    };
  }
  LidarFinding find(const std::string& path = "/dev/lidar", int baud = 0) {
    return LidarSearch(path, baud, opener(), test::virtualNow).find(cancel);
  }
  test::VirtualLine& line() { return line_; }
  int opened() const { return opened_; }
  const Bytes& sent() const { return sent_; }

  std::atomic<bool> cancel{false};
  const char* always = nullptr;  ///< what it sends each millisecond

 private:
  std::unique_ptr<sim::EmulatedLidar> device_;
  int baud_, opened_ = 0;
  bool garbled_ = false;
  Bytes answers_, sent_;
  std::mt19937 random_{1};
  test::VirtualLine line_;
};

std::unique_ptr<sim::EmulatedLidar> packetLidar(const char* driver) {
  return std::make_unique<sim::PacketEmulator>(test::lidarRoom, driver);
}
std::unique_ptr<sim::EmulatedLidar> rplidar(const sim::LidarIdentity& unit) {
  return std::make_unique<sim::LidarEmulator>(test::lidarRoom, unit.turn_rate, unit);
}

TEST(LidarSearch, FindsEachLidarThatSendsOrAnswers) {
  for (const LidarFacts& row : lidarTable()) {
    SCOPED_TRACE(row.driver);
    Port port(packetLidar(row.driver), row.baud);
    const Timestamp begin = virtual_now;
    const LidarFinding found = port.find();
    EXPECT_LT(virtual_now - begin, 6s);
    const std::string_view driver = row.driver;
    if (driver == "lds01" || driver == "coin-d4") {  // each waits for a command that would start another's motor
      EXPECT_EQ(found.family, LidarFinding::kNone);
      continue;
    }
    ASSERT_EQ(found.family, LidarFinding::kPackets) << found.problem.words();
    EXPECT_EQ(found.baud, row.baud);
    if (row.talk.start != nullptr) {
      EXPECT_STREQ(found.facts->driver, row.driver);
    }
    EXPECT_EQ(found.facts->packets, row.packets);
    EXPECT_EQ(found.facts->sample_rate, row.sample_rate) << found.facts->driver;
  }
}

TEST(LidarSearch, FindsEachRplidarAtItsBaudRate) {
  for (const sim::NamedIdentity& unit : sim::namedIdentities()) {
    SCOPED_TRACE(unit.name);
    Port port(rplidar(unit.make()), unit.make().baud);
    const LidarFinding found = port.find();
    EXPECT_EQ(found.family, LidarFinding::kRplidar) << found.problem.words();
    EXPECT_EQ(found.baud, unit.make().baud);
  }
}

TEST(LidarSearch, FindsHokuyoAndSick) {
  for (const sim::ScipModel& model : sim::scipModels()) {
    Port port(std::make_unique<sim::ScipEmulator>(test::lidarRoom, model), 0);
    EXPECT_EQ(port.find().family, LidarFinding::kHokuyo) << model.name;
    Port network(std::make_unique<sim::ScipEmulator>(test::lidarRoom, model), 0);
    EXPECT_EQ(network.find("tcp://192.168.0.10:10940").family, LidarFinding::kHokuyo);
    EXPECT_EQ(network.opened(), 1);
  }
  Port sick(std::make_unique<sim::ColaEmulator>(test::lidarRoom, sim::colaModels()[0]), 0);
  EXPECT_EQ(sick.find("tcp://192.168.0.1:2112").family, LidarFinding::kSick);
}

TEST(LidarSearch, ListensBeforeItAsks) {
  Port port(packetLidar("ld19"), 230400);
  const Timestamp begin = virtual_now;
  EXPECT_EQ(port.find().family, LidarFinding::kPackets);
  EXPECT_TRUE(port.sent().empty());
  EXPECT_LE(virtual_now - begin, 500ms);
}

TEST(LidarSearch, DistinguishesModelsOfOnePacketByTheirRate) {
  Port ld19(packetLidar("ld19"), 230400), stl19p(packetLidar("stl19p"), 230400);
  EXPECT_EQ(ld19.find().facts->sample_rate, 4500.0);
  EXPECT_EQ(stl19p.find().facts->sample_rate, 5000.0);
}

TEST(LidarSearch, SendsNothingThatIsNotHarmless) {
  Port port(nullptr, 0);
  EXPECT_EQ(port.find().family, LidarFinding::kNone);
  const Bytes& sent = port.sent();
  ASSERT_GT(sent.size(), 4U);
  for (std::size_t i = 0; i + 1 < sent.size(); ++i) {
    if (sent[i] != 0xA5) continue;
    EXPECT_TRUE(sent[i + 1] == 0x50 || sent[i + 1] == 0x90) << "neither reset, nor stop, nor start";
  }
}

TEST(LidarSearch, ClaimsNoLidarWhereThereIsNone) {
  Port silent(nullptr, 0), noise(packetLidar("ld19"), 57600), gps(nullptr, 0), gone(nullptr, 0);
  EXPECT_TRUE(silent.find().problem.is(problem::kLidarUnheard));
  const LidarFinding none = noise.find();
  EXPECT_EQ(none.family, LidarFinding::kNone);
  EXPECT_TRUE(none.problem.is(problem::kLidarNotFound)) << none.problem.words();
  gps.always = "$GPGGA,123519,4807.038,N,01131.000,E,1,08,0.9,545.4,M,46.9,M,,*47\r\n";
  EXPECT_TRUE(gps.find().problem.is(problem::kLidarNotFound));
  EXPECT_TRUE(gps.sent().empty()) << "it is known, and is asked nothing";
  gone.line().unplug();
  const LidarFinding missing = gone.find();
  EXPECT_FALSE(missing.is_open);
  EXPECT_TRUE(missing.problem.is(problem::kPortMissing));
}

TEST(LidarSearch, EndsEarlyWhenCancelled) {
  Port port(nullptr, 0);
  port.line().meanwhile = [&, at = virtual_now + 150ms] {
    if (virtual_now > at) port.cancel = true;
  };
  const Timestamp begin = virtual_now;
  EXPECT_TRUE(port.find().problem.is(problem::kStoppedOpening));
  EXPECT_LT(virtual_now - begin, 400ms);
}

TEST(SerialLidar, ReadsTheLidarThatWasFoundAndLooksAgainWhenItIsAnother) {
  auto unit = std::make_unique<Port>(packetLidar("ld19"), 230400);
  int scans = 0, searches = 0;
  const auto find = [&](const PortOpener& open, const std::atomic<bool>& cancel) -> FoundUnit {
    ++searches;
    const LidarFinding found = LidarSearch("/dev/lidar", 0, open, test::virtualNow).find(cancel);
    if (found.facts == nullptr) return {.problem = found.problem, .is_open = found.is_open};
    return {std::make_unique<PacketLidar>(*found.facts, PacketLidarConfig{.baud = found.baud}, test::virtualNow),
            found.baud, found.facts->line_device};
  };
  SerialLidar lidar(
      {.port = "/dev/lidar", .line_device = LineDevice::kUnknown, .find = find}, nullptr, test::virtualNow,
      [&](const LaserScan&) { ++scans; },
      [&](const std::string& path, int baud) { return unit->opener()(path, baud); });
  std::atomic<bool> cancel{false};
  const auto poll = [&](int wanted) {
    const Timestamp end = virtual_now + 5s;
    for (scans = 0; scans < wanted && virtual_now < end;) {
      if (!lidar.poll(50ms)) return false;
    }
    return scans >= wanted;
  };
  ASSERT_TRUE(lidar.connect(cancel)) << lidar.status().problem().words();
  EXPECT_THAT(std::string(lidar.status().identity.load()), HasSubstr("found at 230400 bit/s: LDROBOT LD06"));
  EXPECT_TRUE(poll(3));
  unit->line().unplug();
  EXPECT_FALSE(poll(3));
  unit = std::make_unique<Port>(packetLidar("camsense-x1"), 115200);
  bool again = false;
  for (int i = 0; i < 3 && !again; ++i) again = lidar.connect(cancel);
  ASSERT_TRUE(again) << lidar.status().problem().words();
  EXPECT_EQ(searches, 2);
  EXPECT_TRUE(poll(3));
  EXPECT_THAT(std::string(lidar.status().identity.load()), HasSubstr("Camsense"));
  lidar.stop();
}

TEST(SerialLidar, NamesWhoIsThereWhereNoLidarIsFound) {
  Port gps(nullptr, 0);
  gps.always = "$GPGGA,123519,4807.038,N,01131.000,E,1,08,0.9,545.4,M,46.9,M,,*47\r\n";
  SerialLidar lidar(
      {.port = "/dev/lidar",
       .line_device = LineDevice::kUnknown,
       .find = [](const PortOpener& open, const std::atomic<bool>& cancel) -> FoundUnit {
         const auto found = LidarSearch("/dev/lidar", 0, open, test::virtualNow).find(cancel);
         return {.problem = found.problem, .is_open = found.is_open};
       }},
      nullptr, test::virtualNow, [](const LaserScan&) {}, gps.opener());
  EXPECT_FALSE(lidar.connect(gps.cancel));
  EXPECT_EQ(lidar.status().state.load(), DeviceState::kFault);
  EXPECT_THAT(lidar.status().problem().words(), HasSubstr("a GPS receiver is on this port"));
}

}  // namespace
}  // namespace slam::lidar_search_test
