// SPDX-License-Identifier: BSD-3-Clause
#include <Eigen/Geometry>
#include <cmath>
#include <functional>
#include <gtest/gtest.h>
#include <numbers>
#include <random>
#include <vector>

#include "drivers/imu/codec/bno08x_frames.hpp"
#include "drivers/imu/imu_protocols.hpp"

namespace slam::bno08x_imu_test {
namespace {

using namespace std::chrono_literals;

constexpr double kStep = bno08x::kDegreesPerCount * std::numbers::pi / 180.0;  // [rad]

/// A unit whose frames come at 100 Hz, without delay.
class Unit {
 public:
  Unit() { protocol_->begin(bno08x::kBaud); }
  /// @param heading, pitch, roll [rad]
  void send(double heading, double pitch = 0.0, double roll = 0.0) {
    const auto counts = [](double angle) {
      return static_cast<std::int16_t>(std::lround(std::remainder(angle, 2.0 * std::numbers::pi) / kStep));
    };
    const bno08x::Frame frame{.index = index_++, .yaw = counts(heading), .pitch = counts(pitch), .roll = counts(roll)};
    now_ = std::max(now_, sent_ += 10ms);
    for (const std::uint8_t byte : bno08x::encode(frame))
      protocol_->push(byte, now_, [this](const ImuSample& sample) { samples.push_back(sample); });
  }
  void lose(int frames) {
    index_ = static_cast<std::uint8_t>(index_ + frames);
    sent_ += frames * 10ms;
  }
  /// The computer reads nothing for so long.
  void stall(Duration time) { now_ = sent_ + time; }
  /// It is level, and turns at a rate [rad/s] for so many frames.
  void turn(double rate, int frames, double pitch = 0.0, double roll = 0.0) {
    for (int i = 0; i < frames; ++i) send(heading_ += 0.01 * rate, pitch, roll);
  }

  Timestamp now() const { return now_; }
  std::uint32_t damage() const { return protocol_->damage(); }
  std::vector<ImuSample> samples;

 private:
  std::unique_ptr<ImuProtocol> protocol_ = makeBno08xProtocol();
  Timestamp sent_{1000s}, now_{1000s};
  std::uint8_t index_ = 250;
  double heading_ = 3.0;  // [rad] it wraps soon
};

TEST(Bno08xImu, MakesTheDifferenceOfHeadingsATurnRateAlsoWhereTheyWrap) {
  for (const double rate : {0.7, -0.7, 6.0, -12.0, 30.0}) {
    Unit unit;
    unit.turn(rate, 400);
    ASSERT_GT(unit.samples.size(), 300U);
    for (const ImuSample& sample : unit.samples) {
      ASSERT_NEAR(sample.gyro.z(), rate, 0.01 + 0.002 * std::abs(rate));
      ASSERT_NEAR(sample.gyro.head<2>().norm(), 0.0, 1e-9);
    }
    EXPECT_EQ(unit.damage(), 0U);
  }
}

TEST(Bno08xImu, StampsEachRateInTheMiddleOfItsFrames) {
  Unit unit;
  unit.turn(0.5, 200);
  const double transfer = 190.0 / bno08x::kBaud;  // [s] of a frame
  EXPECT_NEAR(toSeconds(unit.now() - unit.samples.back().stamp), 0.01 + transfer, 1e-4);
}

TEST(Bno08xImu, TurnsAboutTheVerticalHoweverItIsMounted) {
  const double rate = 0.9;
  Unit upside_down;
  upside_down.turn(rate, 200, 0.0, std::numbers::pi);
  EXPECT_NEAR(upside_down.samples.back().gyro.z(), -rate, 0.01) << "about its own axis";
  Unit tilted;
  tilted.turn(rate, 200, 0.5, -0.3);
  const Eigen::Quaterniond q_level_unit =
      Eigen::AngleAxisd(0.5, Eigen::Vector3d::UnitX()) * Eigen::AngleAxisd(-0.3, Eigen::Vector3d::UnitY());
  const Eigen::Vector3d expected = q_level_unit.conjugate() * Eigen::Vector3d(0.0, 0.0, rate);
  EXPECT_LT((tilted.samples.back().gyro - expected).norm(), 0.02);
}

TEST(Bno08xImu, HasTheNoiseThatItsStepOfAnAngleMakesAndNoDrift) {
  // At rest, with noise well above the step: what is left is the rounding's.
  std::mt19937 random(3);
  std::normal_distribution<double> noise(0.0, 2.0 * kStep);
  Unit unit;
  std::vector<double> headings;
  double sum = 0.0, truth = 0.0;
  for (int i = 0; i < 5000; ++i) {
    headings.push_back(1.0 + noise(random));
    unit.send(headings.back());
  }
  const std::size_t skipped = headings.size() - unit.samples.size() - 1;
  for (std::size_t i = 0; i < unit.samples.size(); ++i) {
    truth = (headings[i + skipped + 1] - headings[i + skipped - 1]) / 0.02;
    sum += std::pow(unit.samples[i].gyro.z() - truth, 2);
  }
  const double sigma = std::sqrt(sum / static_cast<double>(unit.samples.size()));
  RecordProperty("sigma_urad_s", static_cast<int>(1e6 * sigma));
  EXPECT_NEAR(sigma, kStep / std::sqrt(12.0) * std::sqrt(2.0) / 0.02, 2e-4) << "3.6 mrad/s";
  double turn = 0.0;
  for (const ImuSample& sample : unit.samples) turn += 0.01 * sample.gyro.z();
  EXPECT_LT(std::abs(turn), 12.0 * kStep) << "the sum of the rates is the heading's change";
}

TEST(Bno08xImu, StandsStillWithinTheSwingThatTheFilterAllows) {
  Unit unit;
  for (int i = 0; i < 1000; ++i) unit.send(5000.4 * kStep + (i / 7 % 2 == 0 ? 0.2 : 0.0) * kStep);
  double least = 0.0, most = 0.0;
  for (const ImuSample& sample : unit.samples) {
    least = std::min(least, sample.gyro.z());
    most = std::max(most, sample.gyro.z());
  }
  EXPECT_GT(most - least, 0.01) << "the step shows";
  EXPECT_LT(most - least, 0.035) << "StandstillConfig::max_gyro_swing";
}

TEST(Bno08xImu, BridgesLostFrames) {
  Unit unit;
  unit.turn(1.0, 200);
  for (const int lost : {1, 2, 5}) {
    unit.lose(lost);
    const std::size_t before = unit.samples.size();
    unit.send(0.0);  // the turn goes on elsewhere: too far for any gyro
    unit.turn(1.0, 20);
    for (std::size_t i = before; i < unit.samples.size(); ++i) ASSERT_LT(unit.samples[i].gyro.norm(), 35.0) << lost;
    EXPECT_NEAR(unit.samples.back().gyro.z(), 1.0, 0.05);
  }
}

TEST(Bno08xImu, HasRightRatesWhereABusyComputerTakesManyFramesAtOnce) {
  Unit unit;
  unit.turn(0.6, 300);
  const std::size_t before = unit.samples.size();
  for (const auto stall : {50ms, 150ms, 300ms, 700ms}) {
    unit.stall(stall);
    unit.turn(0.6, 100);
  }
  for (std::size_t i = before; i < unit.samples.size(); ++i) ASSERT_NEAR(unit.samples[i].gyro.z(), 0.6, 0.02) << i;
}

TEST(Bno08xImu, CountsJumpsOfItsHeading) {
  Unit unit;
  unit.turn(0.0, 200);
  const std::size_t before = unit.samples.size();
  const std::uint32_t damage = unit.damage();
  unit.send(1.0);
  unit.send(1.0);
  unit.send(1.0);
  EXPECT_GT(unit.damage(), damage);
  for (std::size_t i = before; i < unit.samples.size(); ++i) EXPECT_LT(unit.samples[i].gyro.norm(), 0.02);
}

}  // namespace
}  // namespace slam::bno08x_imu_test
