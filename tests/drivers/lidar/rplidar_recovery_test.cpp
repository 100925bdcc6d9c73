// SPDX-License-Identifier: BSD-3-Clause
// The driver against the emulated units of the field and their faults; the driver's own cases are in
// rplidar_driver_test.cpp.
#include <array>
#include <cmath>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <numbers>
#include <tuple>

#include "core/pose2.hpp"
#include "drivers/lidar/lidar_line.hpp"
#include "drivers/lidar/rplidar.hpp"

namespace slam::rplidar_recovery_test {
namespace {

using namespace std::chrono_literals;
using rplidar::Request;
using test::virtual_now;
using testing::HasSubstr;

/// Driver and unit, in virtual time.
struct Rig {
  test::VirtualLidar lidar;
  test::Rplidar driver;
  std::atomic<bool> cancel{false};
  std::vector<LaserScan> scans;

  explicit Rig(const sim::LidarIdentity& identity = sim::a1Firmware129(),
               rplidar::ModeWish mode = rplidar::ModeWish::kDensest, RangeLimits limits = {})
      : lidar(identity),
        driver(
            "", {.scan_mode = mode, .limits = limits}, test::virtualNow,
            [this](const LaserScan& scan) { scans.push_back(scan); }, lidar.line().opener()) {}

  std::string reason() { return driver.status().problem().words(); }
  DeviceState state() { return driver.status().state.load(); }
  bool connect() { return driver.connect(cancel); }
  bool collect(std::size_t count, Duration patience = 20s) {
    const Timestamp deadline = virtual_now + patience;
    for (const std::size_t wanted = scans.size() + count; scans.size() < wanted;) {
      if (!driver.poll(50ms) || virtual_now > deadline) return false;
    }
    return true;
  }
  bool stream(std::size_t count = 2) { return connect() && collect(count); }
  /// As the daemon does it: polls, and connects again when that ends.
  bool streamAgain(std::size_t count = 2) {
    scans.clear();
    bool connected = false;
    const Timestamp deadline = virtual_now + 20s;
    while (scans.size() < count && virtual_now < deadline) connected = connected ? driver.poll(50ms) : connect();
    return scans.size() >= count;
  }
  /// The fault is over: within three seconds there are scans again.
  void expectBackSoon() {
    const Timestamp back = virtual_now;
    EXPECT_TRUE(streamAgain()) << reason();
    EXPECT_LT(virtual_now - back, 3s);
  }
  /// @return how long it took the driver to end the connection; 20 s: it did not
  Duration untilOver() {
    const Timestamp begin = virtual_now;
    while (virtual_now - begin < 20s && driver.poll(100ms)) {
    }
    return virtual_now - begin;
  }
};

void expectRoom(const LaserScan& scan) {
  int wrong = 0;
  double last = -1.0;
  for (const Beam& beam : scan.beams()) {
    const bool edge = std::abs(std::abs(beam.bearing) - 1.57) < 0.03;
    wrong += !edge && std::abs(beam.range - test::lidarRoom({}, beam.bearing)) > 0.005;
    EXPECT_GE(beam.time_offset, last);
    last = beam.time_offset;
  }
  EXPECT_EQ(wrong, 0);
}

struct Unit {
  const char* name;
  sim::LidarIdentity identity;
  std::uint8_t answer_type;
  double sample_us;
};

class RplidarUnit : public testing::TestWithParam<Unit> {};

TEST_P(RplidarUnit, StreamsInItsDensestMode) {
  Rig rig(GetParam().identity);
  ASSERT_TRUE(rig.stream(3)) << rig.reason();
  EXPECT_EQ(rig.driver.mode().answer_type, GetParam().answer_type);
  EXPECT_NEAR(rig.driver.mode().sample_time, 1e-6 * GetParam().sample_us, 1e-9);
  const double samples = 1e6 / GetParam().sample_us / 5.5;
  if (samples < LaserScan::kCapacity) {
    EXPECT_NEAR(rig.scans.back().size, samples, 2.0);
  } else {
    EXPECT_NEAR(rig.scans.back().size, samples / 2.0, 2.0);
    EXPECT_TRUE(rig.driver.status().problem().is(problem::kLidarHalved));
  }
  EXPECT_EQ(rig.driver.status().rejects.load(), 0);
  EXPECT_EQ(rig.state(), DeviceState::kStreaming);
  expectRoom(rig.scans.back());
}

sim::LidarIdentity withDenseMode() {
  sim::LidarIdentity unit = sim::a1Firmware129();
  unit.baud = 256000;
  unit.modes.push_back({100.0, rplidar::AnswerType::kDenseCapsules, "Dense"});
  return unit;
}

INSTANTIATE_TEST_SUITE_P(Of, RplidarUnit,
                         testing::Values(Unit{"A1Firmware115", sim::a1Firmware115(), 0x81, 476},
                                         Unit{"A1Firmware120", sim::a1Firmware120(), 0x82, 476},
                                         Unit{"A1Firmware122", sim::a1Firmware122(), 0x82, 254},
                                         Unit{"A1Firmware124", sim::a1Firmware124(), 0x84, 127},
                                         Unit{"A1Firmware129", sim::a1Firmware129(), 0x84, 127},
                                         Unit{"A2OnItsBoard", sim::a2(), 0x84, 127},
                                         Unit{"WithADenseMode", withDenseMode(), 0x85, 100},
                                         Unit{"A2M12", sim::a2m12(), 0x84, 62.5}, Unit{"A3", sim::a3(), 0x84, 62.5},
                                         Unit{"C1", sim::c1(), 0x85, 200}, Unit{"S1", sim::s1(), 0x85, 108.5},
                                         Unit{"S2", sim::s2(), 0x85, 31.25}, Unit{"S3", sim::s3(), 0x85, 31.25},
                                         Unit{"S3WithUltraDense", sim::s3WithUltraDense(), 0x86, 31.25}),
                         [](const auto& test) { return test.param.name; });

TEST(RplidarModes, NumbersOfAnotherSeriesAreNotOldOnes) {
  for (const auto& [identity, name, mode, sample] :
       {std::tuple(sim::c1(), "RPLidar C1 (model 0x41), firmware 1.01, hardware 18", "DenseBoost (85)", 200.0),
        {sim::s3(), "RPLidar S3 (model 0x81), firmware 1.02, hardware 18", "DenseBoost (85)", 31.25}}) {
    SCOPED_TRACE(name);
    Rig rig(identity);
    ASSERT_TRUE(rig.stream(3)) << rig.reason();
    EXPECT_DOUBLE_EQ(rig.driver.mode().sample_time, 1e-6 * sample);
    const std::string said = rig.driver.status().identity.load();
    EXPECT_THAT(said, testing::AllOf(HasSubstr(name), HasSubstr("serial number 534C414D442D53494D2D303030303031"),
                                     HasSubstr(mode)));
    EXPECT_EQ(rig.driver.status().identified.load(), 1);
    expectRoom(rig.scans.back());
  }
}

TEST(RplidarModes, OfAC1ListARangeThatItDoesNotReach) {
  Rig rig(sim::c1(), rplidar::ModeWish::kDensest, {0.15F, 60.0F});
  ASSERT_TRUE(rig.stream()) << rig.reason();
  EXPECT_DOUBLE_EQ(rig.driver.mode().max_distance, 40.0);
  EXPECT_EQ(rig.scans.back().range_max, 12.0F);
}

TEST(RplidarMotor, OfAnSUnitRunsByItsSpeedControlAndStops) {
  Rig rig(sim::s3());
  ASSERT_TRUE(rig.stream()) << rig.reason();
  EXPECT_EQ(rig.lidar.speed(), 600);
  rig.driver.stop();
  EXPECT_EQ(rig.lidar.speed(), 0);
}

TEST(RplidarFault, ATurnWithMoreMeasurementsThanAScanHoldsIsThinnedAndShown) {
  Rig rig;
  ASSERT_TRUE(rig.stream());
  EXPECT_EQ(rig.driver.status().thinned.load(), 0);
  ASSERT_TRUE(rig.lidar.inject("turn", 572.0));  // 4500 of 127 us
  ASSERT_TRUE(rig.collect(4));
  EXPECT_THAT(rig.reason(), testing::AllOf(HasSubstr("every second one is used"), HasSubstr("motor")));
  EXPECT_EQ(rig.state(), DeviceState::kStreaming);
  const LaserScan& scan = rig.scans.back();
  EXPECT_NEAR(scan.size, 2252, 3);
  std::array<int, 12> sectors{};
  for (const Beam& beam : scan.beams())
    ++sectors[std::min<std::size_t>(11, static_cast<std::size_t>((beam.bearing + std::numbers::pi) / 6.2831854 * 12))];
  for (const int beams : sectors) EXPECT_NEAR(beams, 188, 25);
  EXPECT_NEAR(static_cast<double>(rig.driver.status().thinned.load()), 3 * 2252.0, 2300.0);
  ASSERT_TRUE(rig.lidar.inject("turn", 182.0));
  ASSERT_TRUE(rig.collect(3));
  EXPECT_EQ(rig.reason(), "");
}

TEST(RplidarModes, OfEquallyDenseOnesTheTypicalIsStarted) {
  Rig rig;
  ASSERT_TRUE(rig.connect()) << rig.reason();
  EXPECT_STREQ(rig.driver.mode().name.data(), "Sensitivity");
  EXPECT_EQ(rig.driver.mode().max_distance, 12.0);
}

TEST(RplidarModes, TheDescriptorIsTrustedMoreThanTheList) {
  sim::LidarIdentity unit = sim::a1Firmware129();
  unit.modes[3].listed_type = 0x85;  // streams 84 all the same
  Rig rig(unit);
  ASSERT_TRUE(rig.stream()) << rig.reason();
  EXPECT_EQ(rig.driver.mode().answer_type, 0x84);
  EXPECT_EQ(rig.lidar.count(Request::kExpressScan), 1);
  expectRoom(rig.scans.back());
}

TEST(RplidarModes, AModeThatDoesNotStartIsFollowedByTheNext) {
  sim::LidarIdentity unit = sim::a1Firmware129();
  unit.modes[3].starts = unit.modes[2].starts = false;
  Rig rig(unit);
  ASSERT_TRUE(rig.stream()) << rig.reason();
  EXPECT_STREQ(rig.driver.mode().name.data(), "Stability");
  EXPECT_EQ(rig.lidar.count(Request::kExpressScan), 3);
}

TEST(RplidarModes, StandardIsTheLastResort) {
  sim::LidarIdentity unit = sim::a1Firmware129();
  for (auto& mode : unit.modes) mode.starts = false;
  Rig rig(unit);
  ASSERT_TRUE(rig.stream()) << rig.reason();
  EXPECT_EQ(rig.driver.mode().answer_type, 0x81);
}

TEST(RplidarModes, TheReachOfTheUnitLimitsTheScans) {
  sim::LidarIdentity unit = sim::a1Firmware129();
  for (auto& mode : unit.modes) mode.max_distance = 6.0;
  Rig rig(unit);
  ASSERT_TRUE(rig.stream()) << rig.reason();
  EXPECT_EQ(rig.scans.back().range_max, 6.0F);
  for (auto& mode : unit.modes) mode.max_distance = 0.0;  // firmware that does not tell
  Rig silent(unit);
  ASSERT_TRUE(silent.stream()) << silent.reason();
  EXPECT_EQ(silent.scans.back().range_max, 12.0F);
}

TEST(RplidarMotor, OfAnA2RunsByPwmAndStops) {
  Rig rig(sim::a2());
  ASSERT_TRUE(rig.stream()) << rig.reason();
  EXPECT_EQ(rig.lidar.pwm(), 660);
  rig.driver.stop();
  EXPECT_EQ(rig.lidar.pwm(), 0);
}

/// The only one in real time, and without a limit on it: the port, its rests and the driver's waiting.
TEST(RplidarModes, StreamsThroughAPseudoTerminal) {
  test::LidarLine lidar(sim::a1Firmware129());
  std::vector<LaserScan> scans;
  test::Rplidar driver(lidar.path(), {}, monotonicNow, [&](const LaserScan& scan) { scans.push_back(scan); });
  const std::atomic<bool> cancel{false};
  for (bool connected = false; scans.size() < 2;) connected = connected ? driver.poll(50ms) : driver.connect(cancel);
  expectRoom(scans.back());
}

// ---- Faults

TEST(RplidarFault, BytesOfAnOldStreamBeforeTheFirstAnswer) {
  Rig rig;
  ASSERT_TRUE(rig.lidar.inject("stale", 1500));
  EXPECT_TRUE(rig.stream()) << rig.reason();
}

TEST(RplidarFault, SilenceIsNoticedWithinASecondAndHealedWithinThree) {
  Rig rig;
  ASSERT_TRUE(rig.stream()) << rig.reason();
  ASSERT_TRUE(rig.lidar.inject("silent", 1));
  EXPECT_LT(rig.untilOver(), 1s);
  EXPECT_EQ(rig.state(), DeviceState::kStale);
  EXPECT_THAT(rig.reason(), HasSubstr("no answer"));
  EXPECT_THAT(rig.reason(), HasSubstr("5 V"));
  EXPECT_FALSE(rig.connect());
  EXPECT_THAT(rig.reason(), HasSubstr("port present, but no answer"));
  ASSERT_TRUE(rig.lidar.inject("silent", 0));
  rig.expectBackSoon();
}

TEST(RplidarFault, AReturnInTheMidstOfAConnectIsNotMissed) {
  Rig rig;
  ASSERT_TRUE(rig.lidar.inject("silent", 1));
  std::optional<Timestamp> back;
  rig.lidar.line().meanwhile = [&] {
    if (back || rig.lidar.count(Request::kReset) == 0) return;
    ASSERT_TRUE(rig.lidar.inject("silent", 0));
    back = virtual_now;
  };
  EXPECT_TRUE(rig.streamAgain(1)) << rig.reason();
  ASSERT_TRUE(back) << "it is being reset in vain";
  EXPECT_EQ(rig.scans.size(), 1U);
  EXPECT_LT(virtual_now - *back, 3s);
}

TEST(RplidarFault, AStalledMotorWithHealthOkReportsWhatToCheck) {
  Rig rig;
  ASSERT_TRUE(rig.stream()) << rig.reason();
  ASSERT_TRUE(rig.lidar.inject("stall", 1));
  EXPECT_LT(rig.untilOver(), 1s);
  EXPECT_EQ(rig.reason(), "port present, health OK: check 5 V supply and motor");
  ASSERT_TRUE(rig.lidar.inject("stall", 0));
  rig.expectBackSoon();
}

TEST(RplidarFault, MeasurementsThatMakeNoTurnAreTheHead) {
  Rig rig;
  ASSERT_TRUE(rig.stream()) << rig.reason();
  ASSERT_TRUE(rig.lidar.inject("turn", 60000));  // [ms]
  EXPECT_LT(rig.untilOver(), 3s);
  EXPECT_EQ(rig.state(), DeviceState::kStale);
  EXPECT_THAT(rig.reason(), HasSubstr("the head does not turn"));
  ASSERT_TRUE(rig.lidar.inject("turn", 182));
  rig.expectBackSoon();
}

TEST(RplidarFault, ADescriptorWithoutDataIsTheMotor) {
  Rig rig;
  ASSERT_TRUE(rig.lidar.inject("stall", 1));
  ASSERT_TRUE(rig.connect()) << rig.reason();
  EXPECT_NE(rig.state(), DeviceState::kStreaming);
  EXPECT_LT(rig.untilOver(), 4s) << "the spin-up it grants, and the question for its health";
  EXPECT_THAT(rig.reason(), HasSubstr("the motor does not turn"));
}

TEST(RplidarFault, AWarningOfItsHealthIsReportedWhileItStreams) {
  Rig rig;
  ASSERT_TRUE(rig.lidar.inject("health", 1));
  ASSERT_TRUE(rig.stream()) << rig.reason();
  EXPECT_EQ(rig.state(), DeviceState::kStreaming);
  EXPECT_THAT(rig.reason(), HasSubstr("warns"));
}

TEST(RplidarFault, ProtectionStopInMidScanIsReportedAndLeftWhenItEnds) {
  Rig rig;
  ASSERT_TRUE(rig.stream()) << rig.reason();
  ASSERT_TRUE(rig.lidar.inject("health", 2));
  EXPECT_LT(rig.untilOver(), 1s);
  EXPECT_THAT(rig.reason(), HasSubstr("hardware error"));
  EXPECT_FALSE(rig.connect());
  EXPECT_EQ(rig.state(), DeviceState::kFault);
  EXPECT_EQ(rig.lidar.count(Request::kReset), 3) << "no more than that";
  ASSERT_TRUE(rig.lidar.inject("health", 0));
  EXPECT_TRUE(rig.streamAgain()) << rig.reason();
}

TEST(RplidarFault, ARestartInMidScanIsRecognisedByItsBanner) {
  Rig rig;
  ASSERT_TRUE(rig.stream()) << rig.reason();
  ASSERT_TRUE(rig.lidar.inject("reboot", 1));
  const Timestamp reboot = virtual_now;
  EXPECT_LT(rig.untilOver(), 1s);
  EXPECT_THAT(rig.reason(), HasSubstr("restarted by itself"));
  EXPECT_TRUE(rig.streamAgain()) << rig.reason();
  EXPECT_LT(virtual_now - reboot, 670ms + 3s);
}

TEST(RplidarFault, AnotherBaudRateIsSuspected) {
  Rig rig;
  rig.lidar.garble();
  EXPECT_FALSE(rig.connect());
  EXPECT_THAT(rig.reason(), HasSubstr("check the baud rate"));
  EXPECT_THAT(rig.reason(), HasSubstr("bytes come"));
}

class RplidarDamage : public testing::TestWithParam<std::pair<const char*, double>> {};

TEST_P(RplidarDamage, IsCountedAndTheScansGoOn) {
  Rig rig;
  ASSERT_TRUE(rig.stream()) << rig.reason();
  ASSERT_TRUE(rig.lidar.inject(GetParam().first, GetParam().second));
  ASSERT_TRUE(rig.collect(6)) << rig.reason();
  EXPECT_GT(rig.driver.status().rejects.load(), 0);
  EXPECT_EQ(rig.state(), DeviceState::kStreaming);
  for (const LaserScan& scan : rig.scans) {
    EXPECT_LE(scan.size, 1434) << "never two turns in one";
    expectRoom(scan);
  }
}

INSTANTIATE_TEST_SUITE_P(Of, RplidarDamage,
                         testing::Values(std::pair("lose", 3.0), std::pair("insert", 3.0), std::pair("flip", 20.0),
                                         std::pair("checksum", 4.0), std::pair("encoder_reset", 1.0),
                                         std::pair("pause", 300.0)),
                         [](const auto& test) { return test.param.first; });

TEST(RplidarFault, ALongPauseEndsTheConnectionAndItComesBack) {
  Rig rig;
  ASSERT_TRUE(rig.stream()) << rig.reason();
  ASSERT_TRUE(rig.lidar.inject("pause", 800));
  EXPECT_LT(rig.untilOver(), 1s);
  EXPECT_TRUE(rig.streamAgain()) << rig.reason();
}

TEST(RplidarFault, AnotherSpeedChangesTheBeamsOfATurnAlone) {
  Rig rig;
  ASSERT_TRUE(rig.stream()) << rig.reason();
  for (const double ms : {100.0, 300.0}) {
    ASSERT_TRUE(rig.lidar.inject("turn", ms));
    ASSERT_TRUE(rig.collect(4)) << rig.reason();
    EXPECT_NEAR(rig.scans.back().size, ms / 0.127, 3.0);
    EXPECT_NEAR(rig.scans.back().beams().back().time_offset, 1e-3 * ms, 5e-3);
    expectRoom(rig.scans.back());
  }
}

TEST(RplidarFault, WrongAndStuckRangesComeThroughAsTheyAre) {
  Rig rig;
  ASSERT_TRUE(rig.stream()) << rig.reason();
  ASSERT_TRUE(rig.lidar.inject("wrong", 1.5));
  ASSERT_TRUE(rig.collect(3)) << rig.reason();
  const LaserScan& scan = rig.scans.back();
  for (const Beam& beam : scan.beams()) {
    ASSERT_TRUE(beam.range == 0.0F || std::abs(beam.range - 3.0) < 0.01 || std::abs(beam.range - 4.5) < 0.01);
  }
  ASSERT_TRUE(rig.lidar.inject("stuck", 1));
  EXPECT_TRUE(rig.collect(3)) << rig.reason();
}

}  // namespace
}  // namespace slam::rplidar_recovery_test
