// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/can/can_imu.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <functional>
#include <gtest/gtest.h>
#include <numbers>
#include <random>
#include <vector>

namespace slam::can_imu_test {
namespace {

using namespace std::chrono_literals;
namespace xsens = can::xsens;

constexpr Timestamp kStart{1000s};
constexpr std::uint32_t kStep = 100;  // [ticks] 10 ms

/// Sends samples at 100 Hz; the parts of one come a quarter of a millisecond apart.
struct Unit {
  CanImu imu;
  Timestamp clock = kStart;
  std::uint32_t ticks = 5000;
  float rate = 0.0F;

  std::optional<ImuSample> step(bool time = true, bool turn = true, bool acceleration = true) {
    clock += 10ms;
    ticks += kStep;
    rate += 0.25F;
    std::optional<ImuSample> sample;
    const auto add = [&](const can::Frame& frame, Duration after) {
      if (const auto made = imu.add(frame, clock + after)) sample = made;
    };
    if (time) add(xsens::encodeSampleTime(ticks), 0us);
    if (turn) add(xsens::encodeRateOfTurn({0.0F, 0.0F, rate}), 250us);
    if (acceleration) add(xsens::encodeAcceleration({rate, 0.0F, 9.75F}), 500us);
    return sample;
  }
};

TEST(CanImu, JoinsRateAndAccelerationOfOneSampleTime) {
  Unit unit;
  for (int i = 0; i < 50; ++i) {
    const auto sample = unit.step();
    ASSERT_TRUE(sample);
    EXPECT_EQ(sample->gyro.z(), sample->accel.x()) << "of one sample";
    EXPECT_EQ(sample->accel.z(), 9.75);
    EXPECT_EQ(sample->stamp, unit.clock);
  }
  EXPECT_EQ(unit.imu.rejects(), 0);
}

TEST(CanImu, TurnsReadingsIntoBaseAxes) {
  const Eigen::Matrix3d upside_down = Eigen::AngleAxisd(std::numbers::pi, Eigen::Vector3d::UnitX()).toRotationMatrix();
  CanImu imu(upside_down);
  imu.add(xsens::encodeSampleTime(1), kStart);
  imu.add(xsens::encodeRateOfTurn({0.5F, 0.25F, -1.0F}), kStart);
  const auto sample = imu.add(xsens::encodeAcceleration({0.0F, 0.0F, -9.75F}), kStart);
  ASSERT_TRUE(sample);
  EXPECT_TRUE(sample->gyro.isApprox(Eigen::Vector3d(0.5, -0.25, 1.0), 1e-6));
  EXPECT_TRUE(sample->accel.isApprox(Eigen::Vector3d(0.0, 0.0, 9.75), 1e-6));
}

TEST(CanImu, NeverJoinsPartsOfDifferentSamples) {
  std::mt19937 random(5);
  Unit unit;
  int good = 0;
  for (int i = 0; i < 5000; ++i) {
    const auto sample = unit.step(random() % 5 != 0, random() % 5 != 0, random() % 5 != 0);
    unit.rate = static_cast<float>(i % 50) * 0.25F;  // within what fits
    if (!sample) continue;
    ++good;
    ASSERT_EQ(sample->gyro.z(), sample->accel.x());
  }
  EXPECT_GT(good, 2000);
  EXPECT_GT(unit.imu.rejects(), 500);
}

/// Sends so many samples. @return the share of turn rates that were used
double usedOf(Unit& unit, int count, const std::function<std::array<bool, 3>(int)>& sent) {
  int used = 0;
  for (int i = 0; i < count; ++i) {
    const auto [time, turn, acceleration] = sent(i);
    unit.rate = static_cast<float>(i % 50) * 0.25F;
    const auto sample = unit.step(time, turn, acceleration);
    if (!sample) continue;
    ++used;
    EXPECT_EQ(sample->gyro.z(), static_cast<double>(unit.rate));
    EXPECT_TRUE(sample->accel.isZero() || sample->accel.x() == sample->gyro.z()) << "of another sample";
    EXPECT_LE(std::chrono::abs(sample->stamp - unit.clock), 1ms);
  }
  return static_cast<double>(used) / count;
}

TEST(CanImu, UsesTurnRatesWithoutWhatTheUnitDoesNotSend) {
  Unit no_acceleration, no_time, rate_alone;
  EXPECT_GT(usedOf(no_acceleration, 1000, [](int) { return std::array{true, true, false}; }), 0.95);
  EXPECT_TRUE(no_acceleration.imu.usesTime());
  EXPECT_FALSE(no_acceleration.imu.usesAcceleration());
  EXPECT_GT(usedOf(no_time, 1000, [](int) { return std::array{false, true, true}; }), 0.95);
  EXPECT_FALSE(no_time.imu.usesTime());
  EXPECT_TRUE(no_time.imu.usesAcceleration());
  EXPECT_GT(usedOf(rate_alone, 1000, [](int) { return std::array{false, true, false}; }), 0.92);
  EXPECT_LT(rate_alone.imu.rejects(), 80);
}

TEST(CanImu, UsesEachTurnRateOfAUnitAtMixedRates) {
  for (const int every : {2, 4, 10}) {
    SCOPED_TRACE(every);
    Unit acceleration, time, both;
    EXPECT_GT(usedOf(acceleration, 2000, [every](int i) { return std::array{true, true, i % every == 0}; }), 0.9);
    EXPECT_FALSE(acceleration.imu.usesAcceleration());
    EXPECT_GT(usedOf(time, 2000, [every](int i) { return std::array{i % every == 0, true, true}; }), 0.9);
    EXPECT_FALSE(time.imu.usesTime());
    EXPECT_GT(usedOf(both, 2000, [every](int i) { return std::array{i % every == 0, true, i % every == 0}; }), 0.9);
  }
}

TEST(CanImu, TakesDamagedFramesForNoneThatAreMissing) {
  std::mt19937 random(8);
  Unit unit;
  for (int i = 0; i < 100; ++i) ASSERT_TRUE(unit.step());
  int used = 0;
  for (int i = 0; i < 5000; ++i) {
    unit.clock += 10ms;
    for (const std::uint32_t id : {xsens::kSampleTime, xsens::kRateOfTurn, xsens::kAcceleration}) {
      can::Frame frame{.id = id, .size = static_cast<std::uint8_t>(id == xsens::kSampleTime ? 4 : 6)};
      if (random() % 2 == 0) frame.size = static_cast<std::uint8_t>(random() % 9);
      for (auto& byte : frame.data) byte = static_cast<std::uint8_t>(random());
      used += unit.imu.add(frame, unit.clock).has_value();
    }
  }
  EXPECT_LE(used, 3) << "a random turn rate is worse than none";
  unit.rate = 0.0F;
  for (int i = 0; i < 5; ++i) unit.step();
  unit.rate = 1.0F;
  EXPECT_TRUE(unit.step());
}

TEST(CanImu, JoinsAgainWhatTheUnitSendsAgain) {
  Unit unit;
  usedOf(unit, 200, [](int) { return std::array{false, true, false}; });
  usedOf(unit, 200, [](int) { return std::array{true, true, true}; });
  EXPECT_TRUE(unit.imu.usesTime() && unit.imu.usesAcceleration());
  unit.rate = 1.0F;
  const auto sample = unit.step();
  ASSERT_TRUE(sample);
  EXPECT_EQ(sample->accel.x(), sample->gyro.z());
}

TEST(CanImu, GoesOnOverTheWrapOfTheSampleTime) {
  Unit unit;
  unit.ticks = 0xFFFFFFFFU - 250;
  for (int i = 0; i < 10; ++i) {
    const auto sample = unit.step();
    ASSERT_TRUE(sample);
    EXPECT_EQ(sample->stamp, unit.clock);
  }
}

TEST(CanImu, IsNotBentByADamagedSampleTime) {
  for (const std::uint32_t damage : {0U, 20'000U, 3'000'000'000U, 0xFFFFFFFFU}) {
    Unit unit;
    for (int i = 0; i < 10; ++i) unit.step();
    const std::uint32_t right = unit.ticks;
    unit.ticks = damage;
    EXPECT_FALSE(unit.step());
    unit.ticks = right + kStep;
    const auto sample = unit.step();
    ASSERT_TRUE(sample) << damage;
    EXPECT_EQ(sample->stamp, unit.clock) << damage;
  }
}

TEST(CanImu, BeginsAnewWithTheUnit) {
  for (const std::uint32_t anew : {0U, 2'000'000'000U}) {
    Unit unit;
    for (int i = 0; i < 10; ++i) unit.step();
    unit.ticks = anew;
    EXPECT_FALSE(unit.step()) << "once may be damage";
    for (int i = 0; i < 10; ++i) {
      const auto sample = unit.step();
      ASSERT_TRUE(sample) << anew;
      EXPECT_EQ(sample->stamp, unit.clock);
    }
  }
}

TEST(CanImu, CountsFramesOfAWrongSize) {
  Unit unit;
  can::Frame time = xsens::encodeSampleTime(1), rate = xsens::encodeRateOfTurn({});
  time.size = 8;
  rate.size = 5;
  unit.imu.add(time, kStart);
  unit.imu.add(rate, kStart);
  EXPECT_EQ(unit.imu.rejects(), 2);
  EXPECT_TRUE(unit.step());
}

TEST(CanImu, StampsToAMillisecondUnderJitteredArrival) {
  for (const double drift : {0.0, 100e-6, -100e-6}) {
    CanImu imu;
    std::mt19937 random(4);
    std::exponential_distribution<double> delay(1.0 / 0.002);  // [s] a thread that reads late, without kernel stamps
    std::vector<double> errors;
    for (int i = 1; i < 6000; ++i) {
      const double truth = 0.010 * i;
      const auto ticks = static_cast<std::uint32_t>(truth * (1.0 + drift) * 1e4);
      const Timestamp arrival = kStart + fromSeconds(truth + 0.0005 + std::min(0.008, delay(random)));
      imu.add(xsens::encodeSampleTime(ticks), arrival);
      imu.add(xsens::encodeRateOfTurn({}), arrival);
      const auto sample = imu.add(xsens::encodeAcceleration({}), arrival);
      if (sample && i > 200) errors.push_back(std::abs(toSeconds(sample->stamp - kStart) - truth));
    }
    ASSERT_GT(errors.size(), 5700U);
    std::sort(errors.begin(), errors.end());
    EXPECT_LT(errors[errors.size() * 95 / 100], 0.001) << drift;
  }
}

TEST(CanImu, ReportsSinceWhenItsValuesAreFrozen) {
  Unit unit;
  unit.step();
  const Timestamp last = unit.clock;
  for (int i = 0; i < 50; ++i) {
    unit.rate -= 0.25F;
    ASSERT_TRUE(unit.step());
  }
  EXPECT_EQ(unit.imu.changed(), last);
  unit.step();
  EXPECT_EQ(unit.imu.changed(), unit.clock);
}

TEST(CanImu, GivesNoStampTwice) {
  Unit unit;
  ASSERT_TRUE(unit.step());
  unit.ticks -= kStep;  // the same sample time again, in new frames
  EXPECT_FALSE(unit.step());
  EXPECT_EQ(unit.imu.rejects(), 1);
  EXPECT_TRUE(unit.step());
  Unit late;  // three samples that a thread reads at once, which does not know when they came
  int made = 0;
  for (int i = 0; i < 3; ++i) {
    late.clock = kStart;
    made += late.step().has_value();
  }
  EXPECT_EQ(made, 1);
}

TEST(CanImu, JoinsNoPartsThatAreEightMillisecondsApart) {
  for (const auto& [apart, joined] : {std::pair(Duration(8ms), true), {Duration(8ms) + 1us, false}}) {
    CanImu imu;
    imu.add(xsens::encodeSampleTime(100), kStart);
    imu.add(xsens::encodeRateOfTurn({}), kStart);
    EXPECT_EQ(imu.add(xsens::encodeAcceleration({}), kStart + apart).has_value(), joined);
    EXPECT_EQ(imu.rejects(), joined ? 0 : 1);
  }
}

TEST(CanImu, FollowsASampleTimeThatIsHalfASecondOffAtMost) {
  for (const auto& [ticks, followed] : {std::pair(4'999U, true), {5'101U, false}}) {
    Unit unit;
    for (int i = 0; i < 3; ++i) ASSERT_TRUE(unit.step());
    unit.ticks += ticks;  // 0.5 s, less or more than a step of 10 ms
    EXPECT_EQ(unit.step().has_value(), followed) << ticks;
  }
}

}  // namespace
}  // namespace slam::can_imu_test
