// SPDX-License-Identifier: BSD-3-Clause
// Runs inside the virtual machine: slamd drives by wheels and IMU on CAN, and by the lidar.
#include <algorithm>
#include <chrono>
#include <csignal>
#include <cstdlib>
#include <gtest/gtest.h>
#include <optional>
#include <slam/drive_t.hpp>

#include "firmware_if/can_odrive.hpp"
#include "integration/fault_matrix.hpp"
#include "vm/virtual_can.hpp"

namespace slam::guest_slamd_test {
namespace {

using namespace std::chrono_literals;
using test::ip;

class SlamdOnCan : public test::FaultMatrix {
 protected:
  /// @param simulator interface of slam-sim, on the same bus
  void drive(const std::string& interface, const std::string& simulator) {
    interface_ = interface;
    ASSERT_TRUE(listener_.good());
    startSimulator("600", "meeting-room", {"--speed", "0.1", "--can", simulator});
    startDaemon({"base.driver='can'", "imu.driver='can'", "can.interface='" + interface + "'", "depth.driver='none'",
                 "runtime.realtime=false"});
    ASSERT_TRUE(listener_.until([&] { return allStreams(); }, 10s)) << summary() << "\n" << daemonLog();
    ASSERT_TRUE(listener_.until([&] { return poseState() == kLocalised; }, 5s)) << summary();
  }
  bool allStreams() { return streams("lidar") && isWell("base") && isWell("imu"); }

  /// Something happens to the interface: it is said in words, the pose goes on by the lidar, and all is well again.
  template <typename Happen, typename Fix>
  void expectNoticed(const std::string& words, Happen&& happen, Fix&& fix) {
    SCOPED_TRACE(words);
    happen();
    const auto begin = test::Clock::now();
    const auto seconds = [&] { return std::chrono::duration<double>(test::Clock::now() - begin).count(); };
    EXPECT_TRUE(listener_.until([&] { return device("base")->reason.find(words) != std::string::npos; }, 10s))
        << summary();
    const double noticed = seconds();
    EXPECT_LT(noticed, 1.1) << "[s]";
    EXPECT_LE(worstStateFor(2s), kDegraded) << summary();
    fix();
    const double fixed = seconds();
    EXPECT_TRUE(listener_.until([&] { return allStreams(); }, 10s)) << summary();
    EXPECT_LT(seconds() - fixed, 3.1) << "[s]";
    std::printf("%s: noticed after %.2f s, streams again after %.2f s\n", words.c_str(), noticed, seconds() - fixed);
  }
  void expectDownAndUp() {
    expectNoticed(
        interface_ + " is down", [&] { ip("set " + interface_ + " down"); }, [&] { ip("set " + interface_ + " up"); });
  }
  void expectRemoved(const std::string& remove, const std::string& bring_back) {
    expectNoticed(
        "interface " + interface_ + " is gone", [&] { ASSERT_EQ(std::system(remove.c_str()), 0) << remove; },
        [&] { ASSERT_EQ(std::system(bring_back.c_str()), 0) << bring_back; });
  }
  void expectTruePoses() {
    const std::size_t end = poses_.size();
    const Compared compared = compare(endDrive(), 0, end, kLocalised);
    std::printf("off by at most %.3f m in %d poses localised\n", compared.worst, compared.poses);
    EXPECT_GT(compared.poses, 50);
    EXPECT_LT(compared.worst, 0.1) << "[m]";
  }

 private:
  std::string interface_;
};

class SlamdOnVirtualCan : public SlamdOnCan {
 protected:
  void SetUp() override {
    SlamdOnCan::SetUp();
    ip("add vcan0 type vcan");
    ip("set vcan0 up");
  }
  void TearDown() override {
    SlamdOnCan::TearDown();
    test::removeVirtualCan();
  }
};

TEST_F(SlamdOnVirtualCan, PassesItsRowOfTheFaultMatrix) {
  drive("vcan0", "vcan0");
  run(rows()[4]);
}

TEST_F(SlamdOnVirtualCan, PassesTheImusRowOfTheFaultMatrix) {
  drive("vcan0", "vcan0");
  run(rows()[5]);
}

TEST_F(SlamdOnVirtualCan, GoesOnByTheLidarWhileTheInterfaceIsDownOrGone) {
  drive("vcan0", "vcan0");
  expectDownAndUp();
  expectRemoved("/real/ip link del vcan0", "/real/ip link add vcan0 type vcan && /real/ip link set vcan0 up");
  expectTruePoses();
}

/// Two drives that keep the last speed they got: all that is on the bus but slamd. They tell that they obey.
class Drives {
 public:
  const std::array<float, 2>& speeds() {
    if (const auto now = test::Clock::now(); now >= next_heartbeat_) {
      next_heartbeat_ = now + 50ms;
      for (const int node : {0x10, 0x18}) {
        const can::Frame heartbeat = can::odrive::encodeHeartbeat(node, {.state = 8});
        peer_.send(heartbeat.id, heartbeat.data);
      }
    }
    can_frame raw{};
    while (peer_.receive(raw)) {
      can::Frame frame{.id = raw.can_id, .size = raw.len};
      std::copy(std::begin(raw.data), std::end(raw.data), frame.data.begin());
      for (std::size_t side = 0; side < 2; ++side) {
        const auto asked = can::odrive::parseInputVelocity(side == 0 ? 0x10 : 0x18, frame);
        if (asked) speeds_[side] = asked->velocity;
      }
    }
    return speeds_;
  }
  bool stand() { return speeds() == std::array<float, 2>{}; }
  bool turn() { return speeds()[0] != 0.0F && speeds_[1] != 0.0F; }

 private:
  test::Peer peer_{"vcan0"};
  test::Clock::time_point next_heartbeat_{};
  std::array<float, 2> speeds_{};  // [turns/s]
};

class SlamdDrives : public SlamdOnVirtualCan {
 protected:
  void start() {
    startDaemon({"base.driver='can'", "base.speed_commands=true", "imu.driver='none'", "lidar.driver='none'",
                 "depth.driver='none'", "can.interface='vcan0'", "runtime.realtime=false"});
  }
  void driveUntilTheWheelsTurn() {
    ASSERT_TRUE(listener_.until(
        [this] {
          drive_t drive{};
          drive.utime =
              std::chrono::duration_cast<std::chrono::microseconds>(std::chrono::system_clock::now().time_since_epoch())
                  .count();
          drive.vx = 0.1;
          listener_.lcm().publish(channel::kDrive, &drive);
          return drives_->turn();
        },
        20s))
        << daemonLog();
  }
  bool standWithin(std::chrono::milliseconds limit) {
    return listener_.until([this] { return drives_->stand(); }, limit);
  }

  std::optional<Drives> drives_;
};

TEST_F(SlamdDrives, StopsTheWheelsThatOneThatWasKilledLeftTurning) {
  ASSERT_TRUE(listener_.good());
  drives_.emplace();
  start();
  driveUntilTheWheelsTurn();
  slamd_->signal(SIGKILL);
  ASSERT_EQ(slamd_->wait(5s), 128 + SIGKILL);
  ASSERT_FALSE(standWithin(2s)) << "nobody stops them";
  start();
  EXPECT_TRUE(standWithin(5s)) << daemonLog();

  driveUntilTheWheelsTurn();
  ip("del vcan0");
  listener_.listenFor(3s);
  ip("add vcan0 type vcan");
  drives_.emplace();
  ip("set vcan0 up");
  // The new interface has a new peer, which knows of no speed yet: any frame that it gets is a zero.
  can_frame first{};
  test::Peer peer("vcan0");
  const auto begin = test::Clock::now();
  EXPECT_TRUE(listener_.until([&] { return peer.receive(first); }, 5s)) << daemonLog();
  EXPECT_LT(test::Clock::now() - begin, 200ms);
  EXPECT_TRUE(drives_->stand());

  for (const int number : {SIGHUP, SIGTERM, SIGINT}) {
    driveUntilTheWheelsTurn();
    slamd_->signal(number);
    EXPECT_EQ(slamd_->wait(10s), 0) << daemonLog();
    EXPECT_TRUE(drives_->stand()) << number;
    start();
  }
}

class SlamdOnController : public SlamdOnCan {};

TEST_F(SlamdOnController, GoesOnByTheLidarWhileTheInterfaceIsDownOrGone) {
  drive("can0", "can1");
  expectDownAndUp();
  expectRemoved("echo 1 >/sys/class/net/can0/device/remove",
                "echo 1 >/sys/bus/pci/rescan && /real/ip link set can0 type can bitrate 500000 restart-ms 100 && "
                "/real/ip link set can0 txqueuelen 256 && /real/ip link set can0 up");
  expectTruePoses();
}

}  // namespace
}  // namespace slam::guest_slamd_test
