// SPDX-License-Identifier: BSD-3-Clause
// Each IMU of the table at its emulator.
#include "drivers/imu/serial_imu.hpp"

#include <algorithm>
#include <cmath>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <limits>
#include <numbers>
#include <string_view>

#include "core/plausibility.hpp"
#include "drivers/imu/imu_rig.hpp"
#include "support/allocations.hpp"

namespace slam::serial_imu_test {
namespace {

using namespace std::chrono_literals;
using test::ImuRig;
using test::virtual_now;
using testing::HasSubstr;

class EachImu : public testing::TestWithParam<const char*> {
 protected:
  const char* word() const { return GetParam(); }
  bool is(std::string_view other) const { return other == word(); }
};

constexpr double kSwing = 1.2, kPeriod = 4.0;  // [rad/s], [s]
double swing(double t) { return kSwing * std::sin(2.0 * std::numbers::pi * t / kPeriod); }

/// Turn that the samples from one on add up to, each held since the one before [rad].
double turned(const std::vector<ImuSample>& samples, std::size_t from) {
  double turn = 0.0;
  for (std::size_t i = from + 1; i < samples.size(); ++i)
    turn += samples[i].gyro.z() * toSeconds(samples[i].stamp - samples[i - 1].stamp);
  return turn;
}

TEST_P(EachImu, MeasuresTurnsAndGravityInItsOwnAxes) {
  ImuRig rig(word());
  rig.rate = [](double) { return 0.8; };
  ASSERT_TRUE(rig.connect()) << rig.words();
  rig.runFor(2s);
  const std::size_t from = rig.samples.size() - 1;
  rig.runFor(20s);
  const double time = toSeconds(rig.samples.back().stamp - rig.samples[from].stamp);
  EXPECT_NEAR(turned(rig.samples, from), 0.8 * time, 0.01) << "also where its heading wraps";
  EXPECT_NEAR(static_cast<double>(rig.samples.size() - from - 1), 100.0 * time, 5.0);
  for (std::size_t i = from; i < rig.samples.size(); ++i) {
    ASSERT_NEAR(rig.samples[i].gyro.z(), 0.8, 0.03);
    ASSERT_NEAR(rig.samples[i].accel.z(), 9.80665, 0.02);
    ASSERT_NEAR(rig.samples[i].gyro.x(), 0.0, 0.02);
  }
  EXPECT_EQ(rig.imu.status().rejects, 0);
}

TEST_P(EachImu, StampsWhatItMeasuresUnderJitteredArrival) {
  ImuRig rig(word());
  rig.rate = swing;
  std::mt19937 random(6);
  std::exponential_distribution<double> jitter(1.0 / 0.002);
  rig.delay = [&] { return fromSeconds(std::min(0.02, jitter(random))); };
  ASSERT_TRUE(rig.connect()) << rig.words();
  rig.runFor(10s);
  rig.samples.clear();
  rig.runFor(20s);
  ASSERT_GT(rig.samples.size(), 1900U);
  std::vector<double> errors;  // [rad/s]
  for (std::size_t i = 0; i < rig.samples.size(); ++i) {
    const double t = toSeconds(rig.samples[i].stamp - rig.start());
    errors.push_back(std::abs(rig.samples[i].gyro.z() - swing(t)));
    ASSERT_TRUE(i == 0 || rig.samples[i].stamp > rig.samples[i - 1].stamp);
  }
  std::sort(errors.begin(), errors.end());
  const double steepest = kSwing * 2.0 * std::numbers::pi / kPeriod;  // [rad/s^2]
  // The emulated BNO08x has the mean of the period that has just ended, 5 ms; its differences are as coarse as 4
  // mrad/s.
  const double late = is("bno08x") ? 0.008 : 0.004, coarse = is("bno08x") ? 0.01 : 0.005;
  EXPECT_LT(errors[errors.size() * 95 / 100], steepest * late + coarse);
}

TEST_P(EachImu, IsNamedInItsFaultsAndGoesOnBehindThem) {
  const std::pair<const char*, const char*> faults[] = {
      {"silent", "the IMU sends nothing: check its power"},
      {"garbage", "the IMU's frames cannot be read: check baud rate and cable"},
      {"stuck", "the IMU sends frames, but its values never change: restart it"},
      {"unplug", "the port is gone: unplugged?"},
  };
  for (const auto& [kind, words] : faults) {
    ImuRig rig(word());
    ASSERT_TRUE(rig.connect()) << kind;
    const bool unplug = std::string_view(kind) == "unplug";
    unplug ? rig.line.unplug() : static_cast<void>(rig.emulator->inject(kind, 1.0));
    const Timestamp begin = virtual_now;
    ASSERT_TRUE(rig.runUntil([&] { return rig.state() != DeviceState::kStreaming; })) << kind;
    EXPECT_LE(virtual_now - begin, 1s) << kind;
    EXPECT_THAT(rig.words(), HasSubstr(words));
    const std::size_t before = rig.samples.size();
    rig.runFor(10s);
    EXPECT_EQ(rig.samples.size(), before) << kind;
    unplug ? rig.line.plug() : static_cast<void>(rig.emulator->inject(kind, 0.0));
    const Timestamp end = virtual_now;
    ASSERT_TRUE(rig.connect()) << kind << ": " << rig.words();
    EXPECT_LE(virtual_now - end, 3s) << kind;
    EXPECT_FALSE(rig.imu.status().problem()) << rig.words();
  }
}

TEST_P(EachImu, CountsDamageAndUsesWhatIsWhole) {
  ImuRig rig(word());
  rig.rate = [](double) { return 0.5; };
  ASSERT_TRUE(rig.connect());
  rig.runFor(2s);
  const std::size_t before = rig.samples.size();
  for (const char* kind : {"lose", "insert", "flip", "checksum"}) {
    for (int i = 0; i < 40; ++i) {
      rig.emulator->inject(kind, 2.0);
      rig.runFor(150ms);
    }
  }
  EXPECT_GT(rig.imu.status().rejects, 40);
  EXPECT_GT(rig.samples.size() - before, 1500U) << "of 2400";
  std::size_t jumps = 0;
  for (std::size_t i = before; i < rig.samples.size(); ++i)
    jumps += std::abs(rig.samples[i].gyro.z() - 0.5) > 0.3 ? 1 : 0;
  EXPECT_LE(jumps, 2U) << "a sum of eight bits is right by chance once in 256 times";
  rig.runFor(1s);
  EXPECT_EQ(rig.state(), DeviceState::kStreaming) << rig.words();
}

TEST_P(EachImu, HandsOnNothingThatNoSensorMeasures) {
  ImuRig rig(word());
  ASSERT_TRUE(rig.connect());
  rig.emulator->inject("absurd", 1.0);
  rig.runFor(100ms);
  const std::size_t before = rig.samples.size();
  rig.runFor(2s);
  for (std::size_t i = before; i < rig.samples.size(); ++i) {
    ASSERT_TRUE(isPlausible(rig.samples[i]));
    ASSERT_FALSE(rig.samples[i].rate_known) << "counts at the end of their range";
  }
  if (rig.samples.size() == before) {
    EXPECT_EQ(rig.state(), DeviceState::kStale);
    EXPECT_TRUE(rig.has(problem::kImuSenseless)) << rig.words();
    EXPECT_GT(rig.imu.status().rejects, 100);
  }
  rig.emulator->inject("absurd", 0.0);
  rig.runFor(1s);
  EXPECT_EQ(rig.state(), DeviceState::kStreaming) << rig.words();
  EXPECT_FALSE(rig.imu.status().problem()) << rig.words();
}

TEST_P(EachImu, IsNamedAtAWrongBaudRate) {
  const int right = findImu(word())->bauds.front(), wrong = right == 115200 ? 57600 : 115200;
  ImuRig rig(word(), {}, wrong);
  ASSERT_TRUE(rig.runUntil([&] { return rig.has(problem::kOtherBaud); }, 30s)) << rig.words();
  EXPECT_THAT(rig.words(), HasSubstr("set imu.baud = " + std::to_string(right)));
  EXPECT_TRUE(rig.samples.empty());
}

TEST_P(EachImu, IsFoundAtEachBaudRateOfItsFamily) {
  const ImuFacts& facts = *findImu(word());
  for (std::size_t i = 0; i < facts.baudCount(); ++i) {
    ImuRig rig(word(), {}, 0, facts.bauds[i]);
    rig.emulator->inject("slow", 10.0);  // a WitMotion as delivered sends at 10 Hz
    const Timestamp begin = virtual_now;
    const bool found = rig.runUntil([&] { return rig.samples.size() > 3 || rig.imu.status().samples > 3; }, 20s);
    EXPECT_TRUE(found || is("bno08x")) << facts.bauds[i] << ": " << rig.words();
    EXPECT_EQ(rig.imu.baud(), facts.bauds[i]);
    EXPECT_TRUE(is("bno08x") || virtual_now - begin < 8s) << facts.bauds[i];
    // Where it was found it is looked for first when it is back.
    rig.emulator->inject("slow", 1.0);
    rig.line.unplug();
    rig.runFor(5s);
    rig.line.plug();
    const Timestamp back = virtual_now;
    ASSERT_TRUE(rig.connect()) << facts.bauds[i] << ": " << rig.words();
    EXPECT_LE(virtual_now - back, 3s);
  }
}

TEST_P(EachImu, IsNamedWhereAnotherIsExpected) {
  const char* other = is("xsens") ? "bno08x" : "xsens";
  ImuRig rig(word(), other);
  ASSERT_TRUE(rig.runUntil([&] { return rig.has(problem::kForeignImu) || rig.has(problem::kImuUndecoded); }, 30s))
      << rig.words();
  ASSERT_TRUE(rig.runUntil([&] { return rig.has(problem::kForeignImu); }, 30s)) << rig.words();
  EXPECT_THAT(rig.words(), HasSubstr(std::string("set imu.driver = \"") + word() + "\""));
}

TEST_P(EachImu, DoesNotAllocateOnceItsPortIsOpen) {
  ImuRig rig(word());
  ASSERT_TRUE(rig.connect());
  rig.samples.reserve(10000);
  rig.runFor(1s);
  // The rig allocates in between, so one tick after the other is looked at.
  std::uint64_t allocations = 0;
  for (int i = 0; i < 400; ++i) {
    rig.line.pass(5ms);
    allocations += test::allocationsDuring([&] { rig.imu.tick(); });
  }
  EXPECT_EQ(allocations, 0U);
}

TEST_P(EachImu, IsWrittenToOnlyWhereItsProtocolNeedsIt) {
  ImuRig rig(word());
  ASSERT_TRUE(rig.connect());
  rig.runFor(5s);
  EXPECT_TRUE(rig.written.empty()) << "it sends";
  rig.emulator->inject("silent", 1.0);
  rig.runFor(2s);
  EXPECT_EQ(rig.written.empty(), !is("xsens"));
}

INSTANTIATE_TEST_SUITE_P(, EachImu, testing::Values("hfi", "bno08x", "witmotion", "xsens"),
                         [](const auto& test) { return std::string(test.param); });

TEST(SerialImu, IsSentBackToMeasureWhereItWasLeftInItsConfiguration) {
  ImuRig rig("xsens");
  rig.emulator->inject("config", 1.0);
  const Timestamp begin = virtual_now;
  ASSERT_TRUE(rig.connect()) << rig.words();
  EXPECT_LE(virtual_now - begin, 3s);
  EXPECT_EQ(rig.written, (ImuRig::Bytes{0xFA, 0xFF, 0x10, 0x00, 0xF1})) << "once, and nothing else";
}

TEST(SerialImu, NamesTheOutputThatIsMissing) {
  for (const auto& [driver, output] : {std::pair("witmotion", "0x52"), {"xsens", "8020"}}) {
    ImuRig rig(driver);
    ASSERT_TRUE(rig.connect());
    rig.emulator->inject("no_rate", 1.0);
    rig.runFor(2s);
    EXPECT_EQ(rig.state(), DeviceState::kStale);
    EXPECT_TRUE(rig.has(problem::kImuNoRate)) << rig.words();
    EXPECT_THAT(rig.words(), HasSubstr(output));
    rig.emulator->inject("no_rate", 0.0);
    rig.emulator->inject("no_accel", 1.0);
    rig.runFor(3s);
    EXPECT_EQ(rig.state(), DeviceState::kStreaming);
    EXPECT_TRUE(rig.has(problem::kImuNoAcceleration)) << rig.words();
    EXPECT_TRUE(rig.samples.back().accel.isZero());
  }
}

TEST(SerialImu, KeepsItsStampsWhenTheUnitsClockJumps) {
  ImuRig rig("xsens");
  rig.rate = swing;
  ASSERT_TRUE(rig.connect());
  rig.runFor(2s);
  for (const double jump : {3600.0, -3600.0, 0.3, -0.3, 90000.0}) {
    rig.emulator->inject("clock", jump);
    rig.samples.clear();
    rig.runFor(2s);
    ASSERT_GT(rig.samples.size(), 190U) << jump;
    for (std::size_t i = 0; i < rig.samples.size(); ++i) {
      ASSERT_TRUE(i == 0 || rig.samples[i].stamp > rig.samples[i - 1].stamp) << jump;
      const double t = toSeconds(rig.samples[i].stamp - rig.start());
      ASSERT_NEAR(rig.samples[i].gyro.z(), swing(t), 0.05) << jump;
    }
  }
}

TEST(SerialImu, CountsValuesThatAreNoNumbers) {
  ImuRig rig("xsens");
  ASSERT_TRUE(rig.connect());
  rig.rate = [](double) { return std::numeric_limits<double>::quiet_NaN(); };
  rig.runFor(3s);
  EXPECT_TRUE(rig.has(problem::kImuSenseless)) << rig.words();
  EXPECT_GT(rig.imu.status().rejects, 100);
  for (const ImuSample& sample : rig.samples) ASSERT_TRUE(sample.gyro.allFinite());
}

TEST(SerialImu, NamesTheModePinsOfABno08xThatIsSilent) {
  ImuRig rig("bno08x");
  rig.emulator->inject("silent", 1.0);
  ASSERT_TRUE(rig.runUntil([&] { return rig.has(problem::kImuUnanswered); })) << rig.words();
  EXPECT_THAT(rig.words(), HasSubstr("PS0 is high and PS1 low"));
}

TEST(SerialImu, NamesNobodyInNoise) {
  ImuRig rig("witmotion");
  rig.noise = true;
  ASSERT_TRUE(rig.runUntil([&] { return rig.has(problem::kImuUndecoded); }, 30s)) << rig.words();
  EXPECT_THAT(rig.words(), HasSubstr("what comes is not of a WitMotion IMU"));
  rig.runFor(30s);
  EXPECT_TRUE(rig.samples.empty());
  rig.noise = false;
  ASSERT_TRUE(rig.connect()) << rig.words();
}

}  // namespace
}  // namespace slam::serial_imu_test
