// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <array>
#include <gtest/gtest.h>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "drivers/can/can_base.hpp"
#include "drivers/can/fake_can_port.hpp"

namespace slam::test {

namespace odrive = can::odrive;
namespace xsens = can::xsens;
using namespace std::chrono_literals;

/// Two drives and an IMU on the bus, with what can be taken from them.
class CanBaseTest : public testing::Test {
 protected:
  void start(const CanBaseConfig& config = {}) {
    wheels_.reserve(100000);
    imu_.reserve(100000);
    driver_.emplace(config, FakeCanBus::now,
                    CanBase::Sinks{.wheels = [this](const WheelAngles& angles) { wheels_.push_back(angles); },
                                   .imu = [this](const ImuSample& sample) { imu_.push_back(sample); }},
                    std::make_unique<FakeCanPort>(bus_));
  }
  void runFor(Duration time) {
    for (const Timestamp end = bus_.clock + time; bus_.clock < end;) {
      bus_.clock += 5ms;
      ++step_;
      if (step_ % 2 == 0) putSamples();
      if (step_ % 20 == 0) putHeartbeats();
      driver_->tick();
    }
  }
  void putSamples() {
    for (std::size_t side = 0; side < 2; ++side) {
      if (!drive_[side]) continue;
      if (!frozen_) turns_[side] += speed_[side] * 0.010F;
      if (estimates_) put(odrive::encodeEncoderEstimates(nodes_[side], {turns_[side], speed_[side]}));
    }
    ticks_ += 100;
    if (!frozen_imu_) gyro_ = gyro_ > 0.5F ? 0.25F : gyro_ + 0.125F;
    if (time_) put(xsens::encodeSampleTime(ticks_));
    if (rate_) put(xsens::encodeRateOfTurn({0.0F, 0.0F, gyro_}));
    if (acceleration_) put(xsens::encodeAcceleration({0.0F, 0.0F, 9.75F}));
  }
  void putHeartbeats() {
    for (std::size_t side = 0; side < 2; ++side) {
      if (drive_[side] && heartbeats_) put(odrive::encodeHeartbeat(nodes_[side], heartbeat_[side]));
    }
  }
  void put(const can::Frame& frame) {
    if (connected_) bus_.put(frame);
  }
  std::string wheelReason() { return driver_->wheelStatus().problem().words(); }
  std::string imuReason() { return driver_->imuStatus().problem().words(); }
  DeviceState wheelState() { return driver_->wheelStatus().state; }
  DeviceState imuState() { return driver_->imuStatus().state; }
  void expectStreaming() {
    EXPECT_EQ(wheelState(), DeviceState::kStreaming) << wheelReason();
    EXPECT_EQ(imuState(), DeviceState::kStreaming) << imuReason();
    EXPECT_EQ(wheelReason() + imuReason(), "");
  }

  FakeCanBus bus_;
  std::optional<CanBase> driver_;
  std::vector<WheelAngles> wheels_;
  std::vector<ImuSample> imu_;
  std::array<int, 2> nodes_{odrive::kLeftNode, odrive::kRightNode};
  std::array<float, 2> turns_{3.0F, -7.0F}, speed_{1.0F, 2.0F};  // [turns, turns/s]
  std::array<odrive::Heartbeat, 2> heartbeat_{odrive::Heartbeat{.state = 8}, odrive::Heartbeat{.state = 8}};
  std::array<bool, 2> drive_{true, true};
  bool connected_ = true, estimates_ = true, heartbeats_ = true, time_ = true, rate_ = true, acceleration_ = true;
  bool frozen_ = false, frozen_imu_ = false;
  float gyro_ = 0.0F;  // [rad/s]
  std::uint32_t ticks_ = 1000;
  int step_ = 0;
};

}  // namespace slam::test
