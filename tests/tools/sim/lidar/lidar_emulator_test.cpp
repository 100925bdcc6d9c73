// SPDX-License-Identifier: BSD-3-Clause
#include "tools/sim/lidar/lidar_emulator.hpp"

#include <cmath>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <numbers>
#include <string>
#include <tuple>

#include "core/pose2.hpp"
#include "drivers/lidar/codec/rplidar_modes.hpp"
#include "drivers/lidar/rplidar_scan_stream.hpp"

namespace slam::sim::lidar_emulator_test {
namespace {

using namespace std::chrono_literals;
using rplidar::AnswerType;
using rplidar::Request;
using testing::ElementsAre;
using Bytes = std::vector<std::uint8_t>;

constexpr Timestamp kStart{100s};
constexpr double kTurnRate = 5.5;  // [1/s]
constexpr double kEdge = 1.8;      // [deg] the unit's correction differs by 1.6 between the near and the far side

/// A round room with a dent: 2 m, but 0.6 m from 60 to 90 degrees counter-clockwise, and no wall from -30 to -10.
double dent(Timestamp, double bearing) {
  const double degrees = wrapAngle(bearing) * 180.0 / std::numbers::pi;
  if (degrees > -30.0 && degrees < -10.0) return 0.0;
  return degrees > 60.0 && degrees < 90.0 ? 0.6 : 2.0;
}

/// A unit, its host's clock, and what the host makes of the bytes.
struct Bench {
  LidarEmulator lidar;
  Timestamp now = kStart;
  std::vector<LaserScan> scans;

  explicit Bench(const LidarIdentity& identity = a1Firmware129()) : lidar(dent, kTurnRate, identity) {}

  Bytes ask(const Bytes& request) {
    Bytes out;
    lidar.receive(request, now, out);
    return out;
  }
  Bytes ask(Request request) { return ask(rplidar::encodeRequest(request)); }
  Bytes listen(Duration time) {
    Bytes out;
    for (const Timestamp end = now + time; now < end; now += 2ms) lidar.stream(now, out);
    return out;
  }
  void decode(rplidar::ScanStream& stream, Duration time) {
    for (const Timestamp end = now + time; now < end; now += 2ms) {
      Bytes out;
      lidar.stream(now, out);
      stream.push(out, now, [this](const LaserScan& scan) { scans.push_back(scan); });
    }
  }
};

rplidar::ScanStream streamOf(AnswerType type, double sample_us) {
  return rplidar::ScanStream({.type = type, .sample_time = 1e-6 * sample_us, .limits = {0.1F, 12.0F}});
}

TEST(LidarEmulatorAnswers, TheModeListOfFirmware129ByteForByte) {
  Bench bench;
  EXPECT_THAT(bench.ask(Bytes{0xA5, 0x84, 0x04, 0x70, 0, 0, 0, 0x55}),
              ElementsAre(0xA5, 0x5A, 6, 0, 0, 0, 0x20, 0x70, 0, 0, 0, 5, 0));
  EXPECT_THAT(bench.ask(Bytes{0xA5, 0x84, 0x04, 0x7C, 0, 0, 0, 0x59}),
              ElementsAre(0xA5, 0x5A, 6, 0, 0, 0, 0x20, 0x7C, 0, 0, 0, 3, 0));
  EXPECT_THAT(bench.ask(Bytes{0xA5, 0x84, 0x06, 0x71, 0, 0, 0, 3, 0, 0x55}),
              ElementsAre(0xA5, 0x5A, 8, 0, 0, 0, 0x20, 0x71, 0, 0, 0, 0x00, 0x7F, 0, 0));  // 32512
  EXPECT_THAT(bench.ask(Bytes{0xA5, 0x84, 0x06, 0x75, 0, 0, 0, 3, 0, 0x51}),
              ElementsAre(0xA5, 0x5A, 5, 0, 0, 0, 0x20, 0x75, 0, 0, 0, 0x84));
  const Bytes name = bench.ask(rplidar::encodeConfigurationRequest(rplidar::ConfigurationEntry::kModeName, 3));
  EXPECT_EQ(std::string(name.begin() + 11, name.end()), std::string("Sensitivity") + '\0');
  EXPECT_TRUE(bench.ask(rplidar::encodeConfigurationRequest(rplidar::ConfigurationEntry::kModeName, 5)).empty());
}

TEST(LidarEmulatorAnswers, AreThoseOfTheFirmware) {
  const Bytes count = rplidar::encodeConfigurationRequest(rplidar::ConfigurationEntry::kModeCount);
  EXPECT_TRUE(Bench(a1Firmware122()).ask(count).empty());
  EXPECT_EQ(Bench(a1Firmware124()).ask(count)[11], 3);
  EXPECT_THAT(Bench().ask(Request::kGetSampleRate), ElementsAre(0xA5, 0x5A, 4, 0, 0, 0, 0x15, 0xFC, 1, 0xFE, 0));
  EXPECT_TRUE(Bench(a1Firmware115()).ask(Request::kGetSampleRate).empty());
  EXPECT_TRUE(Bench(a1Firmware115()).ask(rplidar::encodeExpressScan()).empty());
  EXPECT_TRUE(Bench().ask(Bytes{0xA5, 0xFF, 4, 0, 0, 0, 0, 0x5E}).empty()) << "an A1 has no accessory board";
  EXPECT_THAT(Bench(a2()).ask(Bytes{0xA5, 0xFF, 4, 0, 0, 0, 0, 0x5E}),
              ElementsAre(0xA5, 0x5A, 4, 0, 0, 0, 0xFF, 1, 0, 0, 0));
}

TEST(LidarEmulatorAnswers, NothingToARequestWithAWrongChecksum) {
  EXPECT_TRUE(Bench().ask(Bytes{0xA5, 0x84, 0x04, 0x70, 0, 0, 0, 0x54}).empty());
}

struct Mode {
  const char* name;
  AnswerType type;
  double sample_us;
  std::uint8_t id;  ///< of EXPRESS_SCAN; 0: SCAN
};

LidarIdentity withDenseMode() {
  LidarIdentity unit = a1Firmware129();
  unit.modes.push_back({400.0, AnswerType::kDenseCapsules, "Dense"});
  return unit;
}

class LidarEmulatorMode : public testing::TestWithParam<Mode> {
 protected:
  Bytes start() {
    return bench_.ask(GetParam().id == 0 ? rplidar::encodeRequest(Request::kScan)
                                         : rplidar::encodeExpressScan(GetParam().id));
  }
  Bench bench_{withDenseMode()};
  rplidar::ScanStream stream_ = streamOf(GetParam().type, GetParam().sample_us);
};

TEST_P(LidarEmulatorMode, PutsEachRangeWhereItIsSeen) {
  const Bytes descriptor = start();
  ASSERT_EQ(descriptor.size(), rplidar::kDescriptorSize);
  EXPECT_EQ(descriptor.back(), static_cast<std::uint8_t>(GetParam().type));
  bench_.decode(stream_, 2s);
  ASSERT_GE(bench_.scans.size(), 8U);
  int wrong = 0;
  for (const LaserScan& scan : bench_.scans) {
    EXPECT_NEAR(scan.size, 1e6 / GetParam().sample_us / kTurnRate, 2.0);
    for (const Beam& beam : scan.beams()) {
      const double degrees = wrapAngle(beam.bearing) * 180.0 / std::numbers::pi;
      bool edge = false;
      for (const double at : {-30.0, -10.0, 60.0, 90.0}) edge = edge || std::abs(degrees - at) < kEdge;
      wrong += !edge && std::abs(beam.range - dent({}, beam.bearing)) > 0.002;
    }
  }
  EXPECT_EQ(wrong, 0);
  EXPECT_EQ(stream_.rejects(), 0);
}

TEST_P(LidarEmulatorMode, FillsTheLineNoMoreThanItCarries) {
  start();
  Bytes all;
  for (int i = 0; i < 1000; ++i) {
    Bytes out;
    bench_.lidar.stream(bench_.now += 2ms, out);
    EXPECT_LE(out.size(), 24U);  // 23.04 bytes in 2 ms
    all.insert(all.end(), out.begin(), out.end());
  }
  const auto format = rplidar::packetFormat(static_cast<std::uint8_t>(GetParam().type)).value();
  const double rate = static_cast<double>(format.size) / (1e-6 * GetParam().sample_us * format.samples);  // [B/s]
  EXPECT_NEAR(static_cast<double>(all.size()), 2.0 * rate, 2.0 * static_cast<double>(format.size));
}

TEST_P(LidarEmulatorMode, ABrokenByteCostsFewBeams) {
  for (const char* kind : {"lose", "insert", "flip", "checksum"}) {
    Bench bench(withDenseMode());
    rplidar::ScanStream stream = streamOf(GetParam().type, GetParam().sample_us);
    bench.ask(GetParam().id == 0 ? rplidar::encodeRequest(Request::kScan) : rplidar::encodeExpressScan(GetParam().id));
    bench.decode(stream, 1s);
    const auto before = stream.counters().nodes;
    ASSERT_TRUE(bench.lidar.inject(kind, 3));
    bench.decode(stream, 1s);
    const double lost = 1e6 / GetParam().sample_us - static_cast<double>(stream.counters().nodes - before);
    const int packet = rplidar::packetFormat(static_cast<std::uint8_t>(GetParam().type))->samples;
    EXPECT_LE(lost, 9.0 * std::max(packet, 3)) << kind;
    if (GetParam().type != AnswerType::kStandardNodes) {
      EXPECT_GE(lost, packet) << kind;
      EXPECT_GT(stream.rejects(), 0) << kind;
    }
    EXPECT_GE(bench.scans.size(), 8U) << kind;
  }
}

TEST_P(LidarEmulatorMode, EndsAtARequestBehindWhatIsOnTheLine) {
  start();
  bench_.listen(501ms);
  const Bytes out = bench_.ask(Request::kGetHealth);
  ASSERT_GE(out.size(), 10U);
  EXPECT_EQ(Bytes(out.end() - 10, out.end()), (Bytes{0xA5, 0x5A, 3, 0, 0, 0, 6, 0, 0, 0}));
  EXPECT_FALSE(bench_.lidar.scanning());
  EXPECT_TRUE(bench_.listen(500ms).empty());
}

INSTANTIATE_TEST_SUITE_P(Of, LidarEmulatorMode,
                         testing::Values(Mode{"Standard", AnswerType::kStandardNodes, 508.0, 0},
                                         Mode{"Express", AnswerType::kExpressCapsules, 254.0, 1},
                                         Mode{"Boost", AnswerType::kUltraCapsules, 127.0, 2},
                                         Mode{"Stability", AnswerType::kUltraCapsules, 201.0, 4},
                                         Mode{"Dense", AnswerType::kDenseCapsules, 400.0, 5}),
                         [](const auto& test) { return test.param.name; });

// ---- Faults

struct ScanningBench : Bench {
  rplidar::ScanStream stream = streamOf(AnswerType::kUltraCapsules, 127.0);
  explicit ScanningBench(const LidarIdentity& identity = a1Firmware129()) : Bench(identity) {
    ask(rplidar::encodeExpressScan(3));
  }
  void run(Duration time) { decode(stream, time); }
};

TEST(LidarEmulatorFault, UnknownKindsAndBadValuesAreRefused) {
  LidarEmulator lidar(dent, kTurnRate);
  EXPECT_FALSE(lidar.inject("sing", 1));
  EXPECT_FALSE(lidar.inject("", 0));
  EXPECT_FALSE(lidar.inject("silent", 2));
  EXPECT_FALSE(lidar.inject("health", 3));
  EXPECT_FALSE(lidar.inject("health", 0.5));
  EXPECT_FALSE(lidar.inject("lose", -1));
  EXPECT_FALSE(lidar.inject("turn", 0));
  EXPECT_FALSE(lidar.inject("turn", 70000));
  EXPECT_FALSE(lidar.inject("wrong", 0));
  EXPECT_FALSE(lidar.inject("stale", 5000));
  EXPECT_FALSE(lidar.inject("pause", std::nan("")));
}

TEST(LidarEmulatorFault, IsAnotherUnitAfterItsBoot) {
  Bench bench;
  ASSERT_TRUE(bench.lidar.inject("unit", 3.0));
  EXPECT_NE(bench.listen(1s).size(), 0U) << "its banner";
  const Bytes info = bench.ask(Request::kGetInfo);
  ASSERT_EQ(info.size(), 27U);
  EXPECT_THAT(Bytes(info.begin() + 7, info.begin() + 11), ElementsAre(0x81, 0x02, 0x01, 18));
  bench.ask(rplidar::encodeExpressScan(1));
  EXPECT_TRUE(bench.listen(1s).empty()) << "its motor waits for a speed";
  bench.ask(rplidar::encodeMotorSpeed(600));
  bench.listen(600ms);
  EXPECT_NEAR(static_cast<double>(bench.listen(1s).size()), 84.0 * 800.0, 2000.0);
  EXPECT_FALSE(bench.lidar.inject("unit", 2.0));
}

TEST(LidarEmulatorFault, AnotherMakesLidarSendsUnaskedAndReceivesNothing) {
  for (const auto& [make, first, second] : {std::tuple(1.0, 0x54, 0x2C), {2.0, 0xAA, 0x55}}) {
    Bench bench;
    ASSERT_TRUE(bench.lidar.inject("other", make));
    EXPECT_TRUE(bench.ask(Request::kGetInfo).empty());
    const Bytes bytes = bench.listen(1s);
    ASSERT_GT(bytes.size(), 1000U);
    EXPECT_EQ(bytes[0], first);
    EXPECT_EQ(bytes[1], second);
    ASSERT_TRUE(bench.lidar.inject("other", 0.0));
    EXPECT_TRUE(bench.listen(100ms).empty());
    EXPECT_EQ(bench.ask(Request::kGetInfo).size(), 27U);
  }
}

TEST(LidarEmulatorFault, SilentReadsAndReportsNothingUntilItIsOver) {
  ScanningBench bench;
  bench.run(500ms);
  ASSERT_TRUE(bench.lidar.inject("silent", 1));
  EXPECT_TRUE(bench.listen(1s).empty());
  EXPECT_TRUE(bench.ask(Request::kGetHealth).empty());
  EXPECT_TRUE(bench.ask(Request::kStop).empty());
  ASSERT_TRUE(bench.lidar.inject("silent", 0));
  EXPECT_FALSE(bench.listen(100ms).empty()) << "it never heard the STOP";
  EXPECT_FALSE(bench.ask(Request::kGetHealth).empty());
}

TEST(LidarEmulatorFault, AStalledMotorAnnouncesAScanWithoutData) {
  Bench bench;
  ASSERT_TRUE(bench.lidar.inject("stall", 1));
  EXPECT_EQ(bench.ask(rplidar::encodeExpressScan(3)), (Bytes{0xA5, 0x5A, 0x84, 0, 0, 0x40, 0x84}));
  EXPECT_TRUE(bench.listen(1s).empty());
  ASSERT_TRUE(bench.lidar.inject("stall", 0));
  EXPECT_FALSE(bench.listen(100ms).empty());
}

TEST(LidarEmulatorFault, ProtectionStopEndsTheScanAndRefusesAnother) {
  ScanningBench bench;
  bench.run(500ms);
  ASSERT_TRUE(bench.lidar.inject("health", 2));
  bench.listen(20ms);
  EXPECT_TRUE(bench.listen(500ms).empty());
  EXPECT_EQ(bench.ask(Request::kGetHealth)[7], 2);
  EXPECT_TRUE(bench.ask(Request::kScan).empty());
  ASSERT_TRUE(bench.lidar.inject("health", 1));
  EXPECT_EQ(bench.ask(Request::kGetHealth)[7], 1);
  EXPECT_FALSE(bench.ask(Request::kScan).empty());
}

TEST(LidarEmulatorFault, AnEncoderResetIsSeenByALateStartBit) {
  ScanningBench bench;
  bench.run(1s);
  ASSERT_TRUE(bench.lidar.inject("encoder_reset", 1));
  bench.run(1s);
  EXPECT_EQ(bench.stream.counters().encoder_resets, 1U);
  for (const LaserScan& scan : bench.scans) EXPECT_NEAR(scan.size, 1432, 2) << "no turn with two zeros";
}

TEST(LidarEmulatorFault, APauseLacksItsData) {
  ScanningBench bench;
  bench.run(500ms);
  ASSERT_TRUE(bench.lidar.inject("pause", 300));
  bench.listen(20ms);  // what was on the line
  EXPECT_TRUE(bench.listen(270ms).empty());
  EXPECT_FALSE(bench.listen(40ms).empty());
}

TEST(LidarEmulatorFault, TurnSetsTheTimeOfATurn) {
  ScanningBench bench;
  ASSERT_TRUE(bench.lidar.inject("turn", 100));
  bench.run(2s);
  ASSERT_FALSE(bench.scans.empty());
  EXPECT_NEAR(bench.scans.back().size, 100e-3 / 127e-6, 2);
}

TEST(LidarEmulatorFault, ARebootBreaksOffWithTheBannerAndTakesItsTime) {
  ScanningBench bench;
  bench.run(500ms);
  ASSERT_TRUE(bench.lidar.inject("reboot", 1));
  EXPECT_TRUE(bench.listen(600ms).empty());
  EXPECT_TRUE(bench.ask(Request::kGetHealth).empty());
  const Bytes banner = bench.listen(74ms);
  EXPECT_EQ(std::string(banner.begin(), banner.end()),
            "RP LIDAR System.\r\nFirmware Ver 1.29 - rtm, HW Ver 7\r\nModel: 24\r\n");
  EXPECT_FALSE(bench.ask(Request::kGetHealth).empty());
  EXPECT_FALSE(bench.lidar.scanning());
}

TEST(LidarEmulatorFault, StaleBytesComeOnceBeforeAnAnswer) {
  Bench bench;
  ASSERT_TRUE(bench.lidar.inject("stale", 333));
  EXPECT_TRUE(bench.ask(Request::kStop).empty());
  EXPECT_EQ(bench.ask(Request::kGetHealth).size(), 343U);
  EXPECT_EQ(bench.ask(Request::kGetHealth).size(), 10U);
}

TEST(LidarEmulatorFault, StuckRepeatsTheRangesOfATurn) {
  double wall = 2.0;
  Bench bench;
  bench.lidar = LidarEmulator([&](Timestamp, double) { return wall; }, kTurnRate);
  bench.ask(rplidar::encodeExpressScan(3));
  rplidar::ScanStream stream = streamOf(AnswerType::kUltraCapsules, 127.0);
  bench.decode(stream, 600ms);
  ASSERT_TRUE(bench.lidar.inject("stuck", 1));
  bench.decode(stream, 400ms);
  wall = 1.0;
  bench.decode(stream, 600ms);
  for (const Beam& beam : bench.scans.back().beams()) ASSERT_NEAR(beam.range, 2.0, 0.005);
  ASSERT_TRUE(bench.lidar.inject("stuck", 0));
  bench.decode(stream, 600ms);
  for (const Beam& beam : bench.scans.back().beams()) ASSERT_NEAR(beam.range, 1.0, 0.005);
}

TEST(LidarEmulatorFault, WrongMultipliesTheRanges) {
  ScanningBench bench;
  ASSERT_TRUE(bench.lidar.inject("wrong", 1.5));
  bench.run(1s);
  ASSERT_FALSE(bench.scans.empty());
  for (const Beam& beam : bench.scans.back().beams()) {
    ASSERT_TRUE(beam.range == 0.0F || std::abs(beam.range - 3.0) < 0.01 || std::abs(beam.range - 0.9) < 0.01);
  }
}

TEST(LidarEmulator, AnA2ScansOnceItsMotorIsAtSpeed) {
  Bench bench(a2());
  EXPECT_FALSE(bench.ask(rplidar::encodeExpressScan(3)).empty());
  EXPECT_TRUE(bench.listen(1s).empty());
  EXPECT_TRUE(bench.ask(rplidar::encodeMotorPwm(660)).empty());
  EXPECT_TRUE(bench.listen(490ms).empty());
  EXPECT_FALSE(bench.listen(100ms).empty());
  bench.ask(rplidar::encodeMotorPwm(0));
  bench.listen(20ms);
  EXPECT_TRUE(bench.listen(200ms).empty());
}

}  // namespace
}  // namespace slam::sim::lidar_emulator_test
