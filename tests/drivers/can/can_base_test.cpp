// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/can/can_base.hpp"

#include <algorithm>
#include <cmath>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <limits>
#include <map>
#include <numbers>
#include <random>

#include "drivers/can/can_base_fixture.hpp"
#include "support/allocations.hpp"

namespace slam::can_base_test {
namespace {

using namespace std::chrono_literals;
using testing::HasSubstr;
using testing::StartsWith;
namespace odrive = can::odrive;
namespace xsens = can::xsens;
using CanBaseTest = test::CanBaseTest;

constexpr double kTurn = 2.0 * std::numbers::pi;

TEST_F(CanBaseTest, GivesWheelsAndImuAtTheirRates) {
  start();
  runFor(10s);
  expectStreaming();
  EXPECT_NEAR(static_cast<double>(wheels_.size()), 1000.0, 3.0);
  EXPECT_NEAR(static_cast<double>(imu_.size()), 1000.0, 3.0);
  EXPECT_EQ(driver_->wheelStatus().samples.load(), static_cast<std::int64_t>(wheels_.size()));
  EXPECT_EQ(driver_->wheelStatus().rejects.load(), 0);
  EXPECT_EQ(driver_->imuStatus().rejects.load(), 0);
  EXPECT_TRUE(wheels_.front().restarted);
  for (std::size_t i = 1; i < wheels_.size(); ++i) {
    ASSERT_FALSE(wheels_[i].restarted);
    ASSERT_NEAR(wheels_[i].angles[0] - wheels_[i - 1].angles[0], 0.010 * kTurn, 1e-4);
    ASSERT_NEAR(wheels_[i].angles[1] - wheels_[i - 1].angles[1], 0.020 * kTurn, 1e-4);
  }
  EXPECT_EQ(imu_.back().gyro.z(), static_cast<double>(gyro_));
}

TEST_F(CanBaseTest, ReceivesExactlyTheIdsItUses) {
  start();
  runFor(10ms);
  EXPECT_THAT(bus_.ids, testing::UnorderedElementsAre(0x201, 0x209, 0x301, 0x309, 0x005, 0x032, 0x034));
}

TEST_F(CanBaseTest, CanGiveTheWheelsAlone) {
  start({.imu = false});
  runFor(1s);
  EXPECT_THAT(bus_.ids, testing::UnorderedElementsAre(0x201, 0x209, 0x301, 0x309));
  EXPECT_TRUE(imu_.empty());
  EXPECT_GT(wheels_.size(), 90U);
  EXPECT_EQ(wheelState(), DeviceState::kStreaming);
  EXPECT_EQ(imuState(), DeviceState::kAbsent);
}

TEST_F(CanBaseTest, CanGiveTheImuAlone) {
  start({.wheels = false});
  drive_ = {};
  runFor(1s);
  EXPECT_THAT(bus_.ids, testing::UnorderedElementsAre(0x005, 0x032, 0x034));
  EXPECT_TRUE(wheels_.empty());
  EXPECT_GT(imu_.size(), 90U);
  EXPECT_EQ(imuState(), DeviceState::kStreaming);
  EXPECT_EQ(wheelState(), DeviceState::kAbsent);
}

TEST_F(CanBaseTest, UsesOtherNodes) {
  nodes_ = {5, 6};
  start({.nodes = {5, 6}});
  runFor(1s);
  expectStreaming();
}

TEST_F(CanBaseTest, ReportsWithinASecondThatAWheelIsSilent) {
  start();
  runFor(1s);
  drive_[0] = false;
  runFor(1s);
  EXPECT_EQ(wheelState(), DeviceState::kStale);
  EXPECT_THAT(wheelReason(), StartsWith("no frames of the left wheel (node 0x10)"));
  EXPECT_EQ(imuState(), DeviceState::kStreaming);
  drive_ = {true, false};
  runFor(1s);
  EXPECT_THAT(wheelReason(), StartsWith("no frames of the right wheel (node 0x18)"));
  drive_ = {false, false};
  runFor(1s);
  EXPECT_THAT(wheelReason(), HasSubstr("nor of the right wheel"));
  drive_ = {true, true};
  runFor(200ms);
  expectStreaming();
}

TEST_F(CanBaseTest, DistinguishesMissingEstimatesFromMissingHeartbeats) {
  start();
  estimates_ = false;
  runFor(1s);
  EXPECT_EQ(wheelState(), DeviceState::kStale);
  EXPECT_THAT(wheelReason(), HasSubstr("no encoder estimates"));
  estimates_ = true;
  runFor(1s);
  turns_[1] = speed_[1] = std::numeric_limits<float>::quiet_NaN();
  runFor(1s);
  EXPECT_EQ(wheelState(), DeviceState::kStale);
  EXPECT_THAT(wheelReason(),
              testing::AllOf(HasSubstr("right wheel (node 0x18) sends encoder estimates that are no numbers"),
                             testing::Not(HasSubstr("set their rate"))));
  turns_[1] = speed_[1] = 0.0F;
  heartbeats_ = false;
  runFor(2s);
  EXPECT_EQ(wheelState(), DeviceState::kStreaming);
  EXPECT_THAT(wheelReason(), HasSubstr("no heartbeat"));
}

TEST_F(CanBaseTest, ReportsWithinASecondWhatIsMissingOfTheImu) {
  start();
  runFor(1s);
  const auto expectWithout = [&](bool& part, DeviceState state, const char* words) {
    part = false;
    runFor(1s);
    EXPECT_EQ(imuState(), state);
    EXPECT_THAT(imuReason(), HasSubstr(words));
    const auto before = imu_.size();
    runFor(1s);
    EXPECT_EQ(imu_.size() > before + 90, state == DeviceState::kStreaming);
    part = true;
    runFor(2s);
    expectStreaming();
  };
  expectWithout(time_, DeviceState::kStreaming,
                "no sample time (005); slamd takes its readings with the stamps of their");
  expectWithout(rate_, DeviceState::kStale, "no rate of turn (032)");
  expectWithout(acceleration_, DeviceState::kStreaming,
                "no acceleration (034); slamd goes on with its turn rate alone");
  time_ = rate_ = acceleration_ = false;
  runFor(1s);
  EXPECT_THAT(imuReason(), HasSubstr("no frames of the IMU"));
  EXPECT_EQ(wheelState(), DeviceState::kStreaming);
}

TEST_F(CanBaseTest, ReportsWhatIsWrongWithADrive) {
  start();
  runFor(500ms);
  heartbeat_[0] = {.axis_error = 0x800, .state = 1, .controller_error = true};
  const auto before = wheels_.size();
  runFor(300ms);
  EXPECT_EQ(wheelState(), DeviceState::kFault);
  EXPECT_EQ(
      wheelReason(),
      "left wheel: axis error 0x800, controller, disarmed: remove the cause, then cansend can0 218# and cansend can0 "
      "207#08000000");
  EXPECT_GT(wheels_.size(), before + 25) << "a disarmed wheel is still measured";
  heartbeat_[0] = {.state = 1};
  runFor(300ms);
  EXPECT_EQ(wheelState(), DeviceState::kStreaming);
  EXPECT_THAT(wheelReason(), HasSubstr("left wheel (node 0x10) is not in closed loop"));
  heartbeat_[0] = {.state = 8};
  runFor(300ms);
  expectStreaming();
}

TEST_F(CanBaseTest, DoesNotUseAWheelWhoseEncoderFailed) {
  start();
  runFor(500ms);
  heartbeat_[1] = {.axis_error = 0x100, .state = 1, .encoder_error = true};
  runFor(300ms);
  const auto before = wheels_.size();
  runFor(1s);
  EXPECT_EQ(wheels_.size(), before);
  EXPECT_THAT(wheelReason(), StartsWith("right wheel: axis error 0x100, encoder, disarmed"));
}

class CanBaseOf06 : public CanBaseTest {
 protected:
  /// Heartbeats as firmware 0.6 sends them, and estimates.
  void run06(Duration time, std::uint32_t error = 0, std::uint8_t state = 8, std::uint8_t result = 1) {
    heartbeats_ = false;
    for (const Timestamp end = bus_.clock + time; bus_.clock < end;) {
      for (const int node : nodes_) {
        put(odrive::encodeHeartbeat(
            node, {.axis_error = error, .state = state, .trajectory_done = true, .procedure_result = result},
            odrive::Dialect::k06));
      }
      runFor(100ms);
    }
  }
};

TEST_F(CanBaseOf06, TakesAProcedureResultForNoError) {
  start();
  run06(5s);
  expectStreaming();
  EXPECT_GT(wheels_.size(), 450U);
  EXPECT_TRUE(bus_.sent.empty()) << "it may not ask where nothing may be sent";
  run06(1s, 0x01000000, 1, 3);
  EXPECT_EQ(wheelState(), DeviceState::kFault);
  EXPECT_THAT(wheelReason(), StartsWith("left wheel: axis error 0x1000000, disarmed"));
  const auto before = wheels_.size();
  run06(1s, 0x01000000, 1, 3);
  EXPECT_GT(wheels_.size(), before + 90) << "a disarmed wheel is still measured";
}

TEST_F(CanBaseOf06, ServesNodes0And1AsDrivesAreDelivered) {
  nodes_ = {0, 1};
  start({.imu = false, .nodes = {0, 1}});
  run06(2s);
  EXPECT_EQ(wheelState(), DeviceState::kStreaming);
  EXPECT_EQ(wheelReason(), "");
  start({.nodes = {0, 1}});
  run06(2s);
  expectStreaming();
  // With an IMU's quaternion on the id of node 1's heartbeat nothing of that id can be believed.
  for (int i = 0; i < 200; ++i) {
    bus_.put(xsens::encodeQuaternion({0.9F, 0.1F, 0.3F, -0.2F}));
    runFor(10ms);
  }
  EXPECT_EQ(wheelState(), DeviceState::kStreaming) << wheelReason();
  EXPECT_THAT(wheelReason(), testing::AllOf(HasSubstr("quaternion"), HasSubstr("switch the quaternion off")));
}

TEST_F(CanBaseOf06, AsksForTheVersionWhereItMaySend) {
  start({.commands = true});
  run06(500ms);
  const auto asked = [&] {
    return std::count(bus_.sent.begin(), bus_.sent.end(), odrive::requestVersion(0x10)) +
           std::count(bus_.sent.begin(), bus_.sent.end(), odrive::requestVersion(0x18));
  };
  EXPECT_EQ(asked(), 2);
  for (const int node : nodes_) put(odrive::encodeVersion(node, {.firmware = {0, 6, 9}}));
  run06(10s);
  EXPECT_EQ(asked(), 2) << "it knows";
  expectStreaming();
}

TEST_F(CanBaseTest, AsksNoMoreThanThriceWhatIsNeverAnswered) {
  start({.commands = true});
  heartbeat_ = {odrive::Heartbeat{.state = 8, .motor_error = true}, odrive::Heartbeat{.state = 8}};
  runFor(20s);
  EXPECT_EQ(std::count(bus_.sent.begin(), bus_.sent.end(), odrive::requestVersion(0x10)), 3);
  EXPECT_EQ(std::count(bus_.sent.begin(), bus_.sent.end(), odrive::requestVersion(0x18)), 0);
}

TEST_F(CanBaseTest, UsesEstimatesThatComeSeldomAndNamesTheFix) {
  for (const auto& [period, words] :
       {std::pair{50ms, ""}, {100ms, "every 100 ms"}, {200ms, "every 200 ms"}, {450ms, "every 450 ms"}}) {
    SCOPED_TRACE(words);
    start();
    drive_ = {false, false};
    const auto before = wheels_.size();
    for (const Timestamp end = bus_.clock + 10s; bus_.clock < end;) {
      for (std::size_t side = 0; side < 2; ++side) {
        turns_[side] += speed_[side] * static_cast<float>(toSeconds(period)) / 2.0F;
        put(odrive::encodeHeartbeat(nodes_[side], {.state = 8}));
        put(odrive::encodeEncoderEstimates(nodes_[side], {turns_[side], speed_[side] / 2.0F}));
        runFor(side == 0 ? period / 4 / 5ms * 5ms : period - period / 4 / 5ms * 5ms);
      }
    }
    EXPECT_EQ(wheelState(), DeviceState::kStreaming);
    EXPECT_THAT(wheelReason(), HasSubstr(words));
    EXPECT_EQ(wheelReason().find("encoder_msg_rate_ms to 10 to 50") != std::string::npos, *words != '\0');
    EXPECT_GE(wheels_.size() - before, static_cast<std::size_t>(10s / period) - 3);
    EXPECT_EQ(driver_->wheelStatus().rejects.load(), 0);
  }
}

TEST_F(CanBaseTest, DoesNotAcceptASingleHeartbeat) {
  start();
  runFor(500ms);
  bus_.put(odrive::encodeHeartbeat(0x10, {.axis_error = 0xDEAD, .state = 77}));
  runFor(50ms);
  expectStreaming();
}

TEST_F(CanBaseTest, NamesEachErrorOfADrive) {
  start();
  runFor(500ms);
  for (std::uint32_t error = 1; error < 100; ++error) {
    heartbeat_[0] = {.axis_error = error, .state = 1};
    runFor(200ms);
    EXPECT_EQ(wheelState(), DeviceState::kFault);
    char words[64];
    std::snprintf(words, sizeof words, "left wheel: axis error 0x%x, disarmed: ", error);
    EXPECT_THAT(wheelReason(), StartsWith(words));
  }
}

TEST_F(CanBaseTest, NoticesAPositionThatIsFrozenWhileTheWheelTurns) {
  start();
  runFor(500ms);
  frozen_ = true;
  runFor(1s);
  EXPECT_EQ(wheelState(), DeviceState::kFault);
  EXPECT_THAT(wheelReason(), HasSubstr("its position never changes"));
  speed_ = {};
  runFor(1s);
  EXPECT_EQ(wheelState(), DeviceState::kStreaming) << "a wheel that stands may";
}

TEST_F(CanBaseTest, NoticesAnImuThatRepeatsItself) {
  start();
  runFor(500ms);
  frozen_imu_ = true;
  runFor(2s);
  EXPECT_EQ(imuState(), DeviceState::kStale);
  EXPECT_THAT(imuReason(), HasSubstr("never change"));
  const auto before = imu_.size();
  runFor(1s);
  EXPECT_EQ(imu_.size(), before);
  frozen_imu_ = false;
  runFor(100ms);
  expectStreaming();
}

TEST_F(CanBaseTest, HasWordsForAllThatHappensToTheInterface) {
  start();
  runFor(500ms);
  const auto expectWords = [&](DeviceState state, const std::string& words) {
    runFor(200ms);
    EXPECT_EQ(wheelState(), state);
    EXPECT_EQ(imuState(), state);
    EXPECT_EQ(wheelReason(), words);
    EXPECT_EQ(imuReason(), words);
  };
  connected_ = false;
  bus_.pending_error = bus_.interface_error = ENETDOWN;
  expectWords(DeviceState::kAbsent, "can0 is down: ip link set can0 up");
  bus_.interface_error = bus_.open_error = ENODEV;
  expectWords(DeviceState::kAbsent, "interface can0 is gone: adapter unplugged?");
  bus_.interface_error = bus_.open_error = 0;
  connected_ = true;
  runFor(2s);
  expectStreaming();
  connected_ = false;
  bus_.putError(0x40);
  expectWords(DeviceState::kFault, "can0 is bus-off: check wiring and termination");
  bus_.putError(0x100);
  connected_ = true;
  runFor(200ms);
  expectStreaming();
  connected_ = false;
  bus_.putError(0x4, 0x20);
  runFor(1s);
  EXPECT_EQ(wheelState(), DeviceState::kStale);
  EXPECT_THAT(wheelReason(), HasSubstr("error-passive"));
}

TEST_F(CanBaseTest, ReportsThatTheKernelHasNoCan) {
  bus_.open_error = EAFNOSUPPORT;
  start();
  runFor(1s);
  EXPECT_EQ(wheelState(), DeviceState::kAbsent);
  EXPECT_THAT(wheelReason(), HasSubstr("the kernel has no CAN"));
}

TEST_F(CanBaseTest, MarksTheWheelsAfterALongOutage) {
  start();
  runFor(500ms);
  connected_ = false;
  runFor(2s);
  connected_ = true;
  const auto before = wheels_.size();
  runFor(500ms);
  ASSERT_GT(wheels_.size(), before);
  EXPECT_TRUE(wheels_[before].restarted);
  EXPECT_FALSE(wheels_[before + 1].restarted);
}

TEST_F(CanBaseTest, CountsDamageAndGoesOn) {
  start();
  runFor(500ms);
  std::mt19937 random(1);
  for (int i = 0; i < 500; ++i) {
    can::Frame frame{.id = std::array<std::uint32_t, 7>{0x201, 0x209, 0x301, 0x309, 0x5, 0x32, 0x34}[random() % 7],
                     .size = static_cast<std::uint8_t>(random() % 9)};
    for (auto& byte : frame.data) byte = static_cast<std::uint8_t>(random());
    bus_.put(frame);
    bus_.clock += 1ms;
    driver_->tick();
  }
  EXPECT_GT(driver_->wheelStatus().rejects.load(), 100);
  EXPECT_GT(driver_->imuStatus().rejects.load(), 50);
  for (const WheelAngles& angles : wheels_)
    ASSERT_TRUE(std::isfinite(angles.angles[0]) && std::isfinite(angles.angles[1]));
  runFor(500ms);
  expectStreaming();
}

TEST_F(CanBaseTest, RejectsEstimatesThatAreNotFinite) {
  start();
  runFor(500ms);
  speed_[0] = std::numeric_limits<float>::quiet_NaN();
  const auto before = wheels_.size();
  runFor(1s);
  EXPECT_EQ(wheels_.size(), before);
  EXPECT_GE(driver_->wheelStatus().rejects.load(), 100);
  EXPECT_NE(wheelState(), DeviceState::kStreaming);
}

TEST_F(CanBaseTest, DoesNotAllocateInATick) {
  start({.commands = true});
  runFor(1s);
  bus_.sent.reserve(1000);
  heartbeat_[0] = {.axis_error = 0x40, .state = 1};
  std::uint64_t allocations = 0;
  for (int i = 0; i < 200; ++i) {
    bus_.clock += 5ms;
    if (i % 2 == 0) putSamples();
    if (i % 20 == 0) putHeartbeats();
    allocations += test::allocationsDuring([&] {
      driver_->command({.vx = 0.1});
      driver_->tick();
    });
  }
  EXPECT_EQ(allocations, 0U);
  EXPECT_EQ(wheelState(), DeviceState::kFault);
}

}  // namespace
}  // namespace slam::can_base_test
