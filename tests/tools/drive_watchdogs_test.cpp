// SPDX-License-Identifier: BSD-3-Clause
#include "tools/slamctl/drive_watchdogs.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <optional>

#include "drivers/can/fake_can_port.hpp"

namespace slam::drive_watchdogs_test {
namespace {

using namespace std::chrono_literals;
namespace odrive = can::odrive;
using testing::AllOf;
using testing::HasSubstr;

/// Drives of firmware 0.6, which answer.
class AnsweringPort : public test::FakeCanPort {
 public:
  AnsweringPort(test::FakeCanBus& bus, std::uint16_t endpoint, std::array<std::uint32_t, 2> on)
      : FakeCanPort(bus), adapter_(bus), endpoint_(endpoint), on_(on) {}
  int send(const can::Frame& frame) override {
    for (std::size_t side = 0; side < 2; ++side) {
      const int node = side == 0 ? 16 : 24;
      if (frame == odrive::requestVersion(node)) adapter_.put(odrive::encodeVersion(node, {.firmware = {0, 6, 9}}));
      if (frame == odrive::requestParameter(node, endpoint_))
        adapter_.put(odrive::encodeParameter(node, {endpoint_, on_[side]}));
    }
    return FakeCanPort::send(frame);
  }

 private:
  test::FakeCanBus& adapter_;
  std::uint16_t endpoint_;
  std::array<std::uint32_t, 2> on_;
};

class DriveWatchdogs : public testing::Test {
 protected:
  Finding check(CanPort& port, int endpoint = 0) {
    return checkDriveWatchdogs({.left_node = 16, .right_node = 24, .watchdog_endpoint = endpoint}, port, 20ms);
  }
  Finding check() {
    test::FakeCanPort port(bus_);
    return check(port);
  }
  void putHeartbeats(const odrive::Heartbeat& left, const odrive::Heartbeat& right) {
    for (int i = 0; i < 3; ++i) {
      bus_.put(odrive::encodeHeartbeat(16, left));
      bus_.put(odrive::encodeHeartbeat(24, right));
    }
  }
  static constexpr odrive::Heartbeat kArmed{.state = 8, .trajectory_done = true};
  static constexpr odrive::Heartbeat kTripped{.axis_error = 0x800, .state = 1, .trajectory_done = true};
  test::FakeCanBus bus_;
};

TEST_F(DriveWatchdogs, AreOnWhereBothHaveTripped) {
  putHeartbeats(kTripped, kTripped);
  EXPECT_EQ(check().level, Finding::kGood) << check().what;
}

TEST_F(DriveWatchdogs, AreOffInADriveThatStaysArmedWithoutAFrame) {
  putHeartbeats(kTripped, kArmed);
  const Finding finding = check();
  EXPECT_EQ(finding.level, Finding::kFault);
  EXPECT_THAT(finding.what, HasSubstr("right wheel's ODrive is off, or too slow: it stayed armed"));
  EXPECT_THAT(finding.fix, AllOf(HasSubstr("enable_watchdog = True"), HasSubstr("watchdog_timeout = 0.5"),
                                 HasSubstr("save_configuration()")));
}

TEST_F(DriveWatchdogs, AreNotKnownWhereSlamdFeedsThemOrTheDrivesAreIdle) {
  putHeartbeats(kArmed, kArmed);
  for (const int node : {16, 24}) bus_.put(odrive::encodeInputVelocity(node, {}));
  const Finding fed = check();
  EXPECT_EQ(fed.level, Finding::kWarning);
  EXPECT_THAT(fed.what, AllOf(HasSubstr("cannot be seen now, and firmware 0.5 offers no way to ask over CAN"),
                              HasSubstr("off as delivered")));
  EXPECT_THAT(fed.fix, AllOf(HasSubstr("enable_watchdog = True"), HasSubstr("stop slamd, arm the drives")));
  putHeartbeats({.state = 1, .trajectory_done = true}, {.state = 1, .trajectory_done = true});
  EXPECT_EQ(check().level, Finding::kWarning);
  EXPECT_EQ(check().level, Finding::kWarning) << "nothing is heard";
}

TEST_F(DriveWatchdogs, AreReportedByFirmware06WhenItIsAsked) {
  struct {
    std::array<std::uint32_t, 2> on;
    Finding::Level level;
  } const cases[] = {{{1, 1}, Finding::kGood},
                     {{1, 0}, Finding::kFault},
                     {{0, 1}, Finding::kFault},
                     {{77, 77}, Finding::kWarning}};  // that is no switch: another firmware's number
  for (const auto& [on, level] : cases) {
    putHeartbeats({.state = 8}, {.state = 8});
    for (const int node : {16, 24}) bus_.put(odrive::encodeInputVelocity(node, {}));
    AnsweringPort port(bus_, 201, on);
    const Finding finding = check(port, 201);
    EXPECT_EQ(finding.level, level) << finding.what;
    EXPECT_FALSE(bus_.open) << "it is closed again";
  }
  AnsweringPort port(bus_, 201, {1, 1});
  EXPECT_THAT(check(port, 0).fix, HasSubstr("set can.watchdog_endpoint"));
}

}  // namespace
}  // namespace slam::drive_watchdogs_test
