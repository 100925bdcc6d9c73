// SPDX-License-Identifier: BSD-3-Clause
#include "diagnostics/sensor_check.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <numbers>
#include <random>

#include "diagnostics/sensor_problems.hpp"
#include "support/allocations.hpp"

namespace slam::sensor_check_test {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using enum SensorFault;

constexpr double kPi = std::numbers::pi, kDegree = kPi / 180.0;

/// A drive of turns and of straight ways, with what each sensor makes of it; every tenth match is wrong.
struct Drive {
  double lidar_turn = 1.0, lidar_yaw = 0.0;
  double wheel_turn = 1.0, wheel_distance = 1.0, gyro_turn = 1.0;
  bool wheels = true, gyro = true, wheels_turn_known = true, turns = true;
  int pairs = 60;

  SensorCheck check() const {
    std::mt19937 random(1);
    std::normal_distribution<double> noise;
    std::uniform_real_distribution<double> uniform(-1.0, 1.0);
    SensorCheck check;
    for (int i = 0; i < pairs; ++i) {
      const bool turning = turns && i % 2 == 0;
      const Pose2 truth{0.12 * (uniform(random) > -0.8 ? 1.0 : -1.0), 0.0, turning ? 0.3 * uniform(random) : 0.0};
      MotionEvidence evidence;
      const auto noisy = [&](double value) { return value + 0.004 * noise(random); };
      const Eigen::Rotation2Dd yaw(lidar_yaw);
      const Eigen::Vector2d seen = yaw * Eigen::Vector2d(truth.x, 0.5 * truth.x * lidar_turn * truth.theta);
      evidence.scans = {noisy(seen.x()), noisy(seen.y()), noisy(lidar_turn * truth.theta)};
      if (i % 10 == 9) evidence.scans = {0.3 * uniform(random), 0.3 * uniform(random), 0.3 * uniform(random)};
      const double wheel_theta = wheel_turn * truth.theta, told = wheel_distance * truth.x;
      if (wheels) evidence.wheels = Pose2{noisy(told), noisy(0.5 * told * wheel_theta), noisy(wheel_theta)};
      evidence.wheels_turn_known = wheels_turn_known;
      if (gyro) evidence.gyro_turn = noisy(gyro_turn * truth.theta);
      check.add(evidence);
    }
    return check;
  }
  std::vector<SensorFault> faults() const {
    const SensorFindings findings = check().findings();
    std::vector<SensorFault> faults;
    for (const SensorFinding& finding : findings.all()) faults.push_back(finding.fault);
    return faults;
  }
};

TEST(SensorCheck, ReportsNothingOfSensorsThatAgreeRoughly) {
  EXPECT_THAT(Drive{}.faults(), IsEmpty());
  EXPECT_THAT((Drive{.wheel_turn = 0.9, .wheel_distance = 1.1, .gyro_turn = 1.1}).faults(), IsEmpty());
  EXPECT_THAT((Drive{.lidar_yaw = 10 * kDegree}).faults(), IsEmpty());
  EXPECT_THAT((Drive{.wheels = false}).faults(), IsEmpty());
  EXPECT_THAT((Drive{.gyro = false, .turns = false}).faults(), IsEmpty());
  EXPECT_THAT((Drive{.lidar_turn = -1.0, .wheels = false, .gyro = false}).faults(), IsEmpty()) << "nobody contradicts";
}

TEST(SensorCheck, NamesWhichOfThreeTurnsTheWrongWay) {
  EXPECT_THAT((Drive{.lidar_turn = -1.0}).faults(), ElementsAre(kLidarUpsideDown));
  EXPECT_THAT((Drive{.gyro_turn = -1.0}).faults(), ElementsAre(kGyroReversed));
  EXPECT_THAT((Drive{.wheel_turn = -1.0}).faults(), ElementsAre(kWheelsSwapped));
  EXPECT_THAT((Drive{.wheel_turn = -1.0, .wheel_distance = -1.0}).faults(), ElementsAre(kWheelsBackwards));
}

TEST(SensorCheck, LeavesOpenWhoOfTwoTurnsTheWrongWay) {
  EXPECT_THAT((Drive{.lidar_turn = -1.0, .gyro = false}).faults(), ElementsAre(kLidarAgainstWheels));
  EXPECT_THAT((Drive{.lidar_turn = -1.0, .wheels = false}).faults(), ElementsAre(kLidarAgainstGyro));
  EXPECT_THAT((Drive{.lidar_turn = -1.0, .wheels_turn_known = false}).faults(), ElementsAre(kLidarAgainstGyro));
}

TEST(SensorCheck, FindsATurnedLidarAndByHowMuch) {
  for (const double yaw : {180 * kDegree, 90 * kDegree, -45 * kDegree}) {
    const SensorFindings findings = Drive{.lidar_yaw = yaw}.check().findings();
    ASSERT_EQ(findings.size, 1U) << yaw;
    EXPECT_EQ(findings.storage[0].fault, kLidarYawOff);
    EXPECT_NEAR(std::remainder(findings.storage[0].value + yaw, 2 * kPi), 0.0, 4 * kDegree);
  }
  EXPECT_THAT((Drive{.lidar_turn = -1.0, .lidar_yaw = kPi}).faults(), ElementsAre(kLidarUpsideDown, kLidarYawOff));
}

TEST(SensorCheck, FindsWheelsOutOfScale) {
  const SensorFindings distance = Drive{.wheel_distance = 2.0}.check().findings();
  ASSERT_EQ(distance.size, 1U);
  EXPECT_EQ(distance.storage[0].fault, kWheelDistanceOff);
  EXPECT_NEAR(distance.storage[0].value, 2.0, 0.2);
  const SensorFindings turn = Drive{.wheel_turn = 0.4}.check().findings();
  ASSERT_EQ(turn.size, 1U);
  EXPECT_EQ(turn.storage[0].fault, kWheelTurnOff);
  EXPECT_NEAR(turn.storage[0].value, 0.4, 0.06);
  EXPECT_THAT((Drive{.wheel_distance = 1.25, .pairs = 100}).faults(), ElementsAre(kWheelDistanceOff));
  EXPECT_THAT((Drive{.wheel_distance = 1.25, .pairs = 20}).faults(), IsEmpty()) << "few tell it roughly only";
  EXPECT_THAT((Drive{.wheel_distance = 1.08, .pairs = 100}).faults(), IsEmpty());
}

TEST(SensorCheck, FindsWheelsThatStandStillWhileTheLidarMoves) {
  EXPECT_THAT((Drive{.wheel_turn = 0.0, .wheel_distance = 0.0, .pairs = 200}).faults(), ElementsAre(kWheelsContradict));
}

TEST(SensorCheck, WaitsForEvidence) {
  EXPECT_THAT((Drive{.lidar_turn = -1.0, .pairs = 6}).faults(), IsEmpty());
  SensorCheck blind = Drive{.pairs = 0}.check();
  for (int i = 0; i < 100; ++i) {
    blind.add({.scans = {-0.2, 0.0, -0.2},
               .turn_seen = false,
               .travel_seen = false,
               .wheels = Pose2{0.2, 0.0, 0.2},
               .gyro_turn = 0.2});
  }
  EXPECT_EQ(blind.findings().size, 0U) << "what the scans cannot see is no evidence";
}

TEST(SensorCheck, WantsTurnsAndTravelUntilItHasSeenThem) {
  EXPECT_TRUE(SensorCheck().wants(true));
  const SensorCheck straight = Drive{.turns = false}.check();
  EXPECT_TRUE(straight.wants(true));
  EXPECT_FALSE(straight.wants(false));
  EXPECT_FALSE((Drive{.pairs = 200}).check().wants(true));
}

TEST(SensorCheck, CountsRepeatedAndMisdatedScansButForgivesAFew) {
  const auto faults = [](int scans, int repeated, int late, double back) {
    SensorCheck check;
    for (int i = 0; i < scans; ++i) check.addScan(i < repeated, i < late ? back : -0.1);
    const SensorFindings findings = check.findings();
    std::vector<std::pair<SensorFault, double>> found;
    for (const SensorFinding& finding : findings.all()) found.emplace_back(finding.fault, finding.value);
    return found;
  };
  EXPECT_THAT(faults(1000, 9, 50, 0.3), IsEmpty());
  EXPECT_THAT(faults(1000, 20, 0, 0.3), ElementsAre(std::pair(kScansRepeated, 20.0)));
  EXPECT_THAT(faults(1000, 0, 150, 0.3), ElementsAre(std::pair(kTimeBackwards, 150.0)));
  EXPECT_THAT(faults(1000, 0, 1, 30.0), ElementsAre(std::pair(kTimeBackwards, 1.0))) << "a clock was set";
}

TEST(SensorCheck, DescribesEachFaultInALineWithoutQuotationMarks) {
  std::vector<std::string> lines;
  for (std::size_t i = 0; i < kSensorFaults; ++i) {
    lines.push_back(problemOf({static_cast<SensorFault>(i), 2.0}).words());
    EXPECT_GT(lines.back().size(), 20U);
    EXPECT_LT(lines.back().size(), 200U);
    EXPECT_EQ(lines.back().find_first_of("\n\"\\"), std::string::npos);
  }
  std::sort(lines.begin(), lines.end());
  EXPECT_EQ(std::unique(lines.begin(), lines.end()), lines.end());
  EXPECT_THAT(problemOf({kWheelDistanceOff, 2.0}).words(), HasSubstr("200 %"));
  EXPECT_THAT(problemOf({kLidarUpsideDown, 0.0}).words(), HasSubstr("lidar.upside_down"));
}

TEST(SensorCheck, NamesWhatIsWrongWithTheGyroAndWhatSlamdDoesMeanwhile) {
  using enum GyroReliability;
  const auto lines = [](const GyroVerdict& verdict) {
    SensorFindings pairs;
    pairs.add(kGyroReversed);  // what pairs of scans say of it counts no more
    pairs.add(kScansRepeated, 7.0);
    const SensorFindings findings = withGyro(pairs, verdict);
    EXPECT_EQ(findings.all().front().fault, kScansRepeated);
    std::vector<std::string> words;
    for (const SensorFinding& finding : findings.all().subspan(1)) words.push_back(problemOf(finding).words());
    return words;
  };
  const auto all = [](const char* what, const char* meanwhile, const char* fix) {
    return ElementsAre(testing::AllOf(testing::StartsWith("the gyro "), HasSubstr(what), HasSubstr(meanwhile),
                                      testing::ContainsRegex(std::string("; fix: .*") + fix)));
  };
  EXPECT_THAT(lines({}), IsEmpty());
  EXPECT_THAT(lines({kReliable}), IsEmpty());
  const char* without = "slamd goes on without it";
  EXPECT_THAT(lines({kRejected, GyroFault::kReversed, -1.0}), all("turns opposite", without, "turn the IMU over"));
  EXPECT_THAT(lines({kRejected, GyroFault::kDegrees, 57.3}), all("5730 % of the turns: degrees", without, "rad/s"));
  EXPECT_THAT(lines({kRejected, GyroFault::kScale, 0.5}), all("50 % of the turns", without, "range and unit"));
  EXPECT_THAT(lines({kReliable, GyroFault::kOffset, -0.25}), all("-0.250 rad/s at rest", "takes that off", "still"));
  EXPECT_THAT(lines({kRejected, GyroFault::kOffset, 1.0}), all("too much for a bias", without, "replace"));
  EXPECT_THAT(lines({kReliable, GyroFault::kClipped, 1.0}), all("more than 1.000 rad/s", "by the wheels", "range"));
  EXPECT_THAT(lines({kRejected, GyroFault::kUnrelated}), all("does not turn with lidar", without, "mount"));
}

WheelScale learned(double truth, double metres) {
  WheelScale scale;
  for (double way = 0.0; way < metres; way += 0.1) scale.add({0.1 * truth, 0.0, 0.0}, {0.1, 0.0, 0.0}, 2e-4, 1.0);
  return scale;
}

TEST(SensorCheck, TheWholeWayGivesDistancesBetterThanPairs) {
  SensorFindings pairs;
  pairs.add(kWheelTurnOff, 1.7);
  pairs.add(kWheelDistanceOff, 1.4);
  const SensorFindings early = withDistances(pairs, learned(1.2, 0.3));
  ASSERT_EQ(early.size, 2U) << "not known yet";
  EXPECT_EQ(early.storage[1].value, 1.4);

  const SensorFindings better = withDistances(pairs, learned(1.2, 30.0));
  ASSERT_EQ(better.size, 2U);
  EXPECT_EQ(better.storage[0].fault, kWheelTurnOff);
  EXPECT_EQ(better.storage[1].fault, kWheelDistanceOff);
  EXPECT_NEAR(better.storage[1].value, 1.2, 0.01);

  EXPECT_EQ(withDistances(pairs, learned(1.02, 30.0)).size, 1U) << "the pairs were wrong";
  EXPECT_EQ(withDistances({}, learned(0.93, 30.0)).size, 1U) << "the pairs were too coarse";
  SensorFindings backwards;
  backwards.add(kWheelsBackwards);
  EXPECT_EQ(withDistances(backwards, learned(1.2, 30.0)).size, 1U) << "one fault explains the other";
}

TEST(SensorCheck, ReportsAMountThatIsOffOnceItIsSure) {
  const auto known = [](const Eigen::Vector3d& mean, double sigma) {
    return MountError{.mean = mean, .covariance = sigma * sigma * Eigen::Matrix3d::Identity()};
  };
  const SensorFindings turned = withMount({}, known({0.0, 0.0, 0.07}, 0.002));
  ASSERT_EQ(turned.size, 1U);
  EXPECT_EQ(turned.storage[0].fault, kLidarYawOff);
  EXPECT_EQ(turned.storage[0].value, 0.07) << "to add to lidar.yaw";
  const SensorFindings shifted = withMount({}, known({-0.064, 0.01, 0.01}, 0.003));
  ASSERT_EQ(shifted.size, 1U);
  EXPECT_EQ(shifted.storage[0].fault, SensorFault::kLidarMountOff);
  EXPECT_EQ(shifted.storage[0].value, -0.064);
  EXPECT_EQ(shifted.storage[0].second, 0.01);
  EXPECT_EQ(withMount({}, known({-0.064, 0.01, 0.07}, 0.02)).size, 0U) << "it may be chance";
  EXPECT_EQ(withMount({}, known({0.015, 0.0, 0.01}, 0.001)).size, 0U) << "it does little harm";
  SensorFindings reversed;
  reversed.add(kWheelsSwapped);
  EXPECT_EQ(withMount(reversed, known({0.0, 0.0, 0.07}, 0.002)).size, 1U) << "one fault explains the other";
}

TEST(AngleCounts, FindThePeakAcrossTheSeam) {
  AngleCounts angles(2 * kPi);
  for (int i = -10; i <= 10; ++i) angles.add(kPi + i * kDegree);
  for (int i = 0; i < 7; ++i) angles.add(0.9 * i - 2.7);
  EXPECT_NEAR(std::abs(angles.peak().angle), kPi, 3 * kDegree);
  EXPECT_NEAR(angles.peak().share, 0.75, 0.04);
  EXPECT_EQ(angles.count(), 28);
  EXPECT_EQ(angles.between(-kPi, kPi), 28);
  EXPECT_EQ(AngleCounts(1.0).peak().share, 0.0);
}

TEST(SensorCheck, DoesNotAllocate) {
  SensorCheck check;
  EXPECT_EQ(test::allocationsDuring([&] {
              check.add({.scans = {0.1, 0.0, 0.1}, .wheels = Pose2{0.1, 0.0, 0.1}, .gyro_turn = 0.1});
              check.addScan(true, 1.0);
              check.findings();
            }),
            0U);
}

/// Bends of one kind, which the wheels tell as straight ways without a turn, by a lidar that is turned on its mount.
SensorFindings afterBends(double turn, double yaw) {
  SensorCheck check;
  for (int i = 0; i < 40; ++i) {
    const double direction = yaw + 0.5 * turn;
    check.add({.scans = {0.12 * std::cos(direction), 0.12 * std::sin(direction), turn},
               .wheels = Pose2{0.12, 0.0, 0.0},
               .wheels_turn_known = false});
  }
  return check.findings();
}

TEST(SensorCheck, TakesTheDirectionAmidABend) {
  for (const double turn : {-0.19, 0.0, 0.19}) {
    const SensorFindings findings = afterBends(turn, 0.8);
    ASSERT_EQ(findings.size, 1U) << turn;
    EXPECT_EQ(findings.all()[0].fault, kLidarYawOff);
    EXPECT_NEAR(findings.all()[0].value, -0.8, 0.04) << turn;
  }
}

TEST(SensorCheck, ASharpBendHidesTheDirection) {
  for (const double turn : {-0.21, 0.21}) EXPECT_EQ(afterBends(turn, 0.8).size, 0U) << turn;
}

}  // namespace
}  // namespace slam::sensor_check_test
