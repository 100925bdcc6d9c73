// SPDX-License-Identifier: BSD-3-Clause
// Runs inside the virtual machine, as root on a kernel with CAN: the driver in real time.
#include <cmath>
#include <csignal>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <optional>
#include <thread>
#include <vector>

#include "drivers/can/can_base.hpp"
#include "runtime/clock.hpp"
#include "support/process.hpp"
#include "tools/sim/can/can_bus.hpp"
#include "vm/virtual_can.hpp"

namespace slam::guest_driver_test {
namespace {

using namespace std::chrono_literals;
using test::ip;
using test::Peer;
using testing::HasSubstr;

class VirtualCanDriver : public test::VirtualCan {};

/// The driver on one interface and the emulator on another, in real time.
class Pair {
 public:
  Pair(const std::string& driver, const std::string& emulator, can::Protocol protocol = can::Protocol::kOdrive)
      : protocol_(protocol),
        driver_(
            {.interface = driver, .protocol = protocol, .pole_pairs = sim::CanEmulator::kPolePairs, .commands = true},
            monotonicNow,
            {.wheels = [this](const WheelAngles& angles) { wheels_.push_back(angles); },
             .imu = [this](const ImuSample& sample) { imu_.push_back(sample); }}),
        interface_(emulator) {
    plug();
  }
  void plug() { bus_.emplace(interface_, 1, sim::CanEmulator::kNodes, protocol_); }
  void unplug() { bus_.reset(); }

  void runFor(Duration time) {
    runUntil([] { return false; }, time);
  }
  /// @return [s] how long it took, the limit when the condition never held
  template <typename Condition>
  double runUntil(Condition&& condition, Duration limit) {
    const Timestamp begin = monotonicNow();
    for (Timestamp now = begin; now - begin < limit; now = monotonicNow()) {
      const double t = toSeconds(now - origin_);
      const auto noise = static_cast<float>(0.01 * std::sin(1000.0 * t));
      if (bus_) bus_->step(now, {.angles = {2.0 * t, 3.0 * t}, .gyro = {noise, 0, 0.5F}, .accel = {0, 0, 9.75F}});
      driver_.tick();
      if (condition()) return toSeconds(now - begin);
      std::this_thread::sleep_for(2ms);
    }
    return toSeconds(limit);
  }
  bool streaming() {
    return driver_.wheelStatus().state == DeviceState::kStreaming &&
           driver_.imuStatus().state == DeviceState::kStreaming;
  }
  std::string reason() { return driver_.wheelStatus().problem().words(); }

  can::Protocol protocol_;
  std::vector<WheelAngles> wheels_;
  std::vector<ImuSample> imu_;
  CanBase driver_;
  std::optional<sim::CanBus> bus_;

 private:
  std::string interface_;
  Timestamp origin_ = monotonicNow();
};

/// @param wheels that come in 3 s at the least, where the machine does not keep up
void expectSamples(Pair& pair, std::size_t wheels = 200) {
  pair.runFor(3s);
  EXPECT_TRUE(pair.streaming()) << pair.reason();
  EXPECT_GT(pair.wheels_.size(), wheels);  // half as many again where it does
  EXPECT_GT(pair.imu_.size(), 200U);
  EXPECT_EQ(pair.driver_.wheelStatus().rejects.load(), 0);
  const WheelAngles& first = pair.wheels_[10];
  const WheelAngles& last = pair.wheels_.back();
  const double elapsed = toSeconds(last.stamp - first.stamp);
  EXPECT_NEAR((last.angles[0] - first.angles[0]) / elapsed, 2.0, 0.05);
  EXPECT_NEAR((last.angles[1] - first.angles[1]) / elapsed, 3.0, 0.05);
  EXPECT_NEAR(pair.imu_.back().gyro.z(), 0.5, 1e-3);
  pair.driver_.command({.omega = -3.14159265 * 0.0325 / 0.10075});  // half a turn of each wheel a second
  pair.runFor(200ms);
  EXPECT_GE(pair.bus_->emulator().commands(), 8);
  EXPECT_FLOAT_EQ(pair.bus_->emulator().asked()[0], 0.5F);
  EXPECT_FLOAT_EQ(pair.bus_->emulator().asked()[1], -0.5F);
}

TEST_F(VirtualCanDriver, CarriesWheelsImuAndCommands) {
  Pair pair("vcan0", "vcan0");
  expectSamples(pair);
}

TEST_F(VirtualCanDriver, CarriesTwoVescs) {
  Pair pair("vcan0", "vcan0", can::Protocol::kVesc);
  expectSamples(pair, 100);  // as delivered they send at 50 Hz
  ip("set vcan0 down");
  EXPECT_LT(pair.runUntil([&] { return !pair.streaming(); }, 5s), 1.0);
  ip("set vcan0 up");
  EXPECT_LT(pair.runUntil([&] { return pair.streaming(); }, 5s), 2.0);
}

TEST_F(VirtualCanDriver, IsMissedWithinASecondAndUsedAgain) {
  Pair pair("vcan0", "vcan0");
  const auto streaming = [&] { return pair.streaming(); };
  const auto lost = [&] { return !pair.streaming(); };
  ASSERT_LT(pair.runUntil(streaming, 5s), 2.0);

  ip("set vcan0 down");
  EXPECT_LT(pair.runUntil(lost, 5s), 1.0);
  EXPECT_EQ(pair.reason(), "vcan0 is down: ip link set vcan0 up");
  ip("set vcan0 up");
  EXPECT_LT(pair.runUntil(streaming, 5s), 2.0);

  pair.unplug();
  ip("del vcan0");
  EXPECT_LT(pair.runUntil(lost, 5s), 1.0);
  EXPECT_EQ(pair.reason(), "interface vcan0 is gone: adapter unplugged?");
  pair.runFor(1s);
  ip("add vcan0 type vcan");
  ip("set vcan0 up");
  pair.plug();
  EXPECT_LT(pair.runUntil(streaming, 5s), 3.0);
  EXPECT_EQ(pair.driver_.linkCounters().opened, 2U);

  Peer peer("vcan0");
  peer.send(0x20000040);
  pair.bus_->emulator().inject("silent", 1);
  EXPECT_LT(pair.runUntil(lost, 5s), 1.0);
  EXPECT_EQ(pair.reason(), "vcan0 is bus-off: check wiring and termination");
  peer.send(0x20000100);
  pair.bus_->emulator().inject("silent", 0);
  EXPECT_LT(pair.runUntil(streaming, 5s), 2.0);

  pair.bus_->emulator().inject("silent", 1);
  EXPECT_LT(pair.runUntil(lost, 5s), 1.0);
  EXPECT_THAT(pair.reason(), HasSubstr("no frames of the left wheel (node 0x10)"));
}

TEST_F(VirtualCanDriver, IsFedBySlamSim) {
  ip("del vcan0");
  const std::vector<std::string> command = {"slam-sim", "--devices", "/tmp/devices", "--can", "vcan0"};
  EXPECT_EQ(test::Process(command, "/tmp/sim.txt").wait(20s), 1) << "an interface that is not there";
  ip("add vcan0 type vcan");
  ip("set vcan0 up");
  test::Process simulator(command, "/tmp/sim.txt");
  int wheels = 0, samples = 0;
  CanBase driver({.interface = "vcan0"}, monotonicNow,
                 {.wheels = [&](const WheelAngles&) { ++wheels; }, .imu = [&](const ImuSample&) { ++samples; }});
  for (const Timestamp end = monotonicNow() + 20s; (wheels < 200 || samples < 200) && monotonicNow() < end;) {
    driver.tick();
    std::this_thread::sleep_for(2ms);
  }
  EXPECT_EQ(driver.wheelStatus().state, DeviceState::kStreaming) << driver.wheelStatus().problem().words();
  EXPECT_EQ(driver.imuStatus().state, DeviceState::kStreaming) << driver.imuStatus().problem().words();
  EXPECT_GE(wheels, 200);
  EXPECT_GE(samples, 200);
  EXPECT_EQ(driver.wheelStatus().rejects.load(), 0);
  simulator.signal(SIGTERM);
  EXPECT_EQ(simulator.wait(20s), 0);
  if (HasFailure()) std::cout << std::ifstream("/tmp/sim.txt").rdbuf();
}

TEST(EmulatedController, CarriesWheelsImuAndCommandsAtItsBitRate) {
  Pair pair("can0", "can1");
  expectSamples(pair);
}

TEST(EmulatedController, IsMissedWhenItIsTakenDownAndUsedAgain) {
  Pair pair("can0", "can1");
  const auto streaming = [&] { return pair.streaming(); };
  ASSERT_LT(pair.runUntil(streaming, 5s), 2.0);
  ip("set can0 down");
  EXPECT_LT(pair.runUntil([&] { return !pair.streaming(); }, 5s), 1.0);
  EXPECT_EQ(pair.reason(), "can0 is down: ip link set can0 up");
  ip("set can0 up");
  EXPECT_LT(pair.runUntil(streaming, 5s), 2.0);
}

}  // namespace
}  // namespace slam::guest_driver_test
