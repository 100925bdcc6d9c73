// SPDX-License-Identifier: BSD-3-Clause
#include "slam/localizer.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <gtest/gtest.h>
#include <memory>
#include <numeric>
#include <random>
#include <vector>

#include "posegraph/keyframe_graph.hpp"
#include "support/allocations.hpp"
#include "support/simulated_room.hpp"

namespace slam {
namespace {

using namespace std::chrono_literals;

/// Drives a robot with wheels, gyro and a lidar in a room, in virtual time.
class Drive {
 public:
  explicit Drive(const LocalizerConfig& config = {}) : localizer(std::make_unique<Localizer>(config)) {}

  bool wheels = true, imu = true, lidar = true;
  int scan_every = 9;         // of the wheels' samples: 5.6 Hz
  double wheel_factor = 1.0;  // 0: the wheels do not see the motion
  test::Room room{.length = 8.0, .width = 5.0, .range_sigma = 0.01};
  std::unique_ptr<Localizer> localizer;
  Pose2 truth;
  Timestamp now{100s};
  std::function<void(LaserScan&)> rearrange;
  KeyframeGraph* keyframes = nullptr;  // takes what the localizer keeps

  void run(double seconds, const Eigen::Vector3d& twist) {
    const Timestamp end = now + fromSeconds(seconds);
    while (now < end) {
      now += 20ms;
      truth = truth * exp(0.02 * twist);
      dead_reckoned_ = dead_reckoned_ * exp(0.02 * wheel_factor * twist);
      if (wheels) localizer->add(WheelSample{now, dead_reckoned_});
      if (imu) localizer->add(ImuSample{now, {0, 0, twist.z() + 0.01 + 0.001 * noise_(random_)}, {0, 0, 9.81}});
      if (lidar && ++step_ % scan_every == 0) {
        if (!frozen) seen_ = turning ? turn(twist) : stopped();
        LaserScan scan = seen_;
        scan.stamp = turning ? scan.stamp : now;
        if (rearrange) rearrange(scan);
        last = localizer->add(scan);
        if (copied_after > Duration(0)) {
          scan.stamp += copied_after;
          localizer->add(scan);
        }
        if (keyframes && last.keyframe && !last.keyframe->look) keyframes->add(*last.keyframe);
      }
    }
  }
  /// The wheels claim a motion that was none.
  void pretend(const Pose2& jump) { dead_reckoned_ = dead_reckoned_ * jump; }
  double error() const {
    const Pose2 difference = between(truth, localizer->estimate(now).T_map_base);
    return std::hypot(difference.x, difference.y);
  }
  LocalisationState state() const { return localizer->estimate(now).state; }
  double speedError(const Eigen::Vector3d& twist) const {
    return std::abs(localizer->estimate(now).twist.vx - twist.x());
  }
  ScanOutcome last;
  bool frozen = false;       // the lidar shows one turn again and again
  Duration copied_after{0};  // a scan is sent once more, so much later
  bool turning = false;      // the lidar takes its time over a turn, as real ones do

 private:
  LaserScan stopped() {
    LaserScan scan = room.scan(truth, random_);
    scan.stamp = now;
    return scan;
  }
  /// A turn that ends now, while the robot moves.
  LaserScan turn(const Eigen::Vector3d& twist) {
    constexpr double kTurn = 0.18;  // [s]
    LaserScan scan;
    scan.range_min = 0.05F;
    scan.range_max = static_cast<float>(room.reach);
    scan.stamp = now - fromSeconds(kTurn);
    for (int i = 0; i < room.beams; ++i) {
      const double share = static_cast<double>(i) / room.beams, bearing = wrapAngle(2.0 * std::numbers::pi * share);
      const double range = room.range(truth * exp(kTurn * (share - 1.0) * twist), bearing);
      scan.push({.range = static_cast<float>(range + room.range_sigma * noise_(random_)),
                 .bearing = static_cast<float>(bearing),
                 .time_offset = static_cast<float>(kTurn * share)});
    }
    return scan;
  }

  Pose2 dead_reckoned_;
  LaserScan seen_;
  std::mt19937 random_{1};
  std::normal_distribution<double> noise_{0.0, 1.0};
  int step_ = 0;
};

const Eigen::Vector3d kStand(0, 0, 0), kCurve(0.3, 0, 0.4), kSpin(0, 0, 2.0);

TEST(Localizer, FollowsACurveUnderNoiseAndLearnsTheGyroBias) {
  Drive drive;
  drive.run(2.0, kStand);
  drive.run(20.0, kCurve);
  EXPECT_LT(drive.error(), 0.03);
  EXPECT_EQ(drive.state(), LocalisationState::kLocalised);
  EXPECT_NEAR(drive.localizer->odometry(drive.now).gyro_bias, 0.01, 0.002);
  EXPECT_GT(drive.localizer->counters().keyframes, 3U);
}

TEST(Localizer, UsesAScanOnceThatIsSentTwice) {
  Drive drive;
  drive.copied_after = 2ms;
  drive.run(2.0, kStand);
  drive.run(20.0, kCurve);
  EXPECT_LT(drive.error(), 0.03);
  const LocalizerCounters counters = drive.localizer->counters();
  EXPECT_GE(counters.scans_repeated, counters.scans / 2 - 2) << "but the first, whose usual interval is not known";
  EXPECT_LE(counters.matched, counters.scans / 2);
}

TEST(Localizer, DoesNotBelieveALidarThatRepeatsATurn) {
  Drive drive;
  drive.run(2.0, kStand);
  drive.run(8.0, kCurve);
  drive.frozen = true;
  drive.run(4.0, kCurve);
  EXPECT_TRUE(drive.last.stuck);
  EXPECT_LT(drive.error(), 0.1) << "wheels and gyro go on";
  EXPECT_EQ(drive.state(), LocalisationState::kDegraded);
  drive.run(2.0, kStand);
  EXPECT_TRUE(drive.last.stuck) << "what it shows is as old as before";
  EXPECT_LT(drive.error(), 0.1);
  drive.frozen = false;
  drive.run(2.0, kStand);
  EXPECT_FALSE(drive.last.stuck);
  EXPECT_LT(drive.error(), 0.03);
  EXPECT_EQ(drive.state(), LocalisationState::kLocalised);
}

TEST(Localizer, FollowsAFastSpin) {
  Drive drive;
  drive.run(2.0, kStand);
  drive.run(6.0, kSpin);
  EXPECT_LT(drive.error(), 0.03);
  EXPECT_LE(drive.localizer->counters().unmatched + drive.localizer->counters().gated,
            3U);  // the jolt at its begin and end
}

TEST(Localizer, WorksWithScansAlone) {
  Drive drive;
  drive.wheels = drive.imu = false;
  drive.run(1.0, kStand);
  drive.run(15.0, {0.2, 0, 0.2});
  EXPECT_LT(drive.error(), 0.05);
  EXPECT_EQ(drive.state(), LocalisationState::kLocalised);
}

TEST(Localizer, DoesNotSwingAboutTheSpeedOfARobotWithoutWheelsWhoseLidarTakesItsTime) {
  for (const bool imu : {true, false}) {
    SCOPED_TRACE(imu ? "with gyro" : "scans alone");
    Drive drive;
    drive.wheels = false;
    drive.imu = imu;
    drive.turning = true;
    drive.run(1.0, kStand);
    for (const double speed : {0.1, 0.4, 0.2}) {
      const Eigen::Vector3d twist(speed, 0, 0.1);
      drive.run(1.0, twist);
      double worst = 0.0, swing = 0.0;
      for (int i = 0; i < 40; ++i) {
        drive.run(0.1, twist);
        worst = std::max(worst, drive.error());
        swing = std::max(swing, drive.speedError(twist));
      }
      EXPECT_LT(worst, 0.04) << "[m]";
      EXPECT_LT(swing, 0.15) << "[m/s]";
    }
  }
}

TEST(Localizer, BelievesScansWhenTheWheelsSpinOnTheSpot) {
  Drive drive;
  drive.run(2.0, kStand);
  drive.wheel_factor = 2.0;
  drive.run(5.0, {0.15, 0, 0});
  EXPECT_LT(drive.error(), 0.05);
}

TEST(Localizer, FindsItselfAfterTheWheelsPretendedAJump) {
  for (const Pose2 jump : {Pose2{0.5, 0.0, 0.0}, Pose2{-0.3, 0.4, 0.0}, Pose2{0.1, 0.1, 1.0}}) {
    Drive drive;
    drive.imu = false;
    drive.run(2.0, kStand);
    drive.run(4.0, kCurve);
    drive.pretend(jump);
    drive.run(1.0, kCurve);
    EXPECT_LT(drive.error(), 0.05);
    EXPECT_EQ(drive.state(), LocalisationState::kLocalised);
  }
}

TEST(Localizer, OutweighsWheelsThatKeepLying) {
  Drive drive;
  drive.imu = false;
  drive.run(2.0, kStand);
  drive.wheel_factor = -1.0;  // forwards is reported as backwards
  drive.run(10.0, kCurve);
  EXPECT_LT(drive.error(), 0.12);  // the wheels carry the pose astray for up to 180 ms after a scan
  EXPECT_TRUE(drive.last.fused);
}

TEST(Localizer, DoesNotHearWheelsThatKeepLyingUntilTheyTellTheTruth) {
  for (const bool imu : {true, false}) {
    Drive drive;
    drive.imu = imu;
    drive.run(2.0, kStand);
    drive.wheel_factor = -1.0;
    drive.run(30.0, kCurve);
    EXPECT_EQ(drive.localizer->counters().wheels_withdrawn, 1U);
    EXPECT_LT(drive.error(), 0.06);  // of a lidar alone, up to 180 ms after a scan
    drive.wheel_factor = 1.0;
    drive.run(60.0, kCurve);
    EXPECT_LT(drive.error(), 0.03);
    drive.lidar = false;
    drive.run(2.0, kCurve);
    EXPECT_LT(drive.error(), 0.1) << "the wheels are not heard again";
    EXPECT_EQ(drive.localizer->counters().wheels_withdrawn, 1U);
  }
}

TEST(Localizer, CorrectsWheelsOfAWrongRadius) {
  for (const double factor : {0.75, 1.2, 1.5}) {
    Drive drive;
    drive.wheel_factor = factor;
    drive.run(2.0, kStand);
    drive.run(20.0, kCurve);
    EXPECT_NEAR(drive.localizer->counters().wheels_scale, factor, 0.03 * factor);
    EXPECT_EQ(drive.localizer->counters().wheels_withdrawn, 0U) << factor;
    drive.lidar = false;
    drive.run(8.0, kCurve);
    EXPECT_LT(drive.error(), 0.1) << factor;
  }
}

TEST(Localizer, WheelsThatFellSilentAreNotJudgedMeanwhile) {
  for (const bool imu : {true, false}) {
    Drive drive;
    drive.imu = imu;
    drive.run(2.0, kStand);
    drive.wheels = false;
    drive.run(20.0, kCurve);
    EXPECT_LT(drive.error(), 0.06) << "of a lidar alone";
    EXPECT_NEAR(drive.localizer->counters().wheels_scale, 1.0, 0.02);
    EXPECT_EQ(drive.localizer->counters().wheels_withdrawn, 0U);
    drive.wheels = true;
    drive.run(4.0, kCurve);
    EXPECT_NEAR(drive.localizer->counters().wheels_scale, 1.0, 0.05);
    drive.lidar = false;
    drive.run(4.0, kCurve);
    EXPECT_LT(drive.error(), 0.1);
  }
}

TEST(Localizer, ASparseScanDoesNotHoldTheRobotInACorridor) {
  for (const int beams : {60, 90, 120}) {
    Drive drive;
    drive.room = {.length = 80.0, .width = 2.0, .reach = 10.0, .range_sigma = 0.01, .beams = beams};
    drive.run(2.0, kStand);
    drive.run(20.0, {0.4, 0, 0});
    EXPECT_LT(drive.error(), 0.15) << beams << " beams; the wheels are right";
    EXPECT_EQ(drive.localizer->counters().wheels_withdrawn, 0U) << beams;
  }
}

TEST(Localizer, IsNotHeldInACorridorByWallsSeenTooFlat) {
  for (const double width : {1.6, 2.0, 3.0}) {
    for (const int beams : {180, 360, 720}) {
      for (const bool imu : {true, false}) {
        Drive drive;
        drive.imu = imu;
        drive.room = {.length = 80.0, .width = width, .reach = 12.0, .range_sigma = 0.01, .beams = beams};
        drive.run(2.0, kStand);
        drive.run(25.0, {0.4, 0, 0});
        EXPECT_LT(drive.error(), 0.2) << width << " m wide, " << beams << " beams; the wheels are right";
        EXPECT_EQ(drive.localizer->counters().wheels_withdrawn, 0U) << width << " m wide, " << beams << " beams";
      }
    }
  }
}

/// Where a beam meets a person's legs, or as far as it went without the person.
float behind(const Pose2& lidar, const Beam& beam, const Eigen::Vector2d& person) {
  constexpr double kRadius = 0.2;  // [m]
  const double bearing = lidar.theta + beam.bearing;
  const Eigen::Vector2d direction(std::cos(bearing), std::sin(bearing)), to = person - lidar.translation();
  const double along = to.dot(direction), inside = kRadius * kRadius - (to.squaredNorm() - along * along);
  if (along <= 0.0 || inside <= 0.0) return beam.range;
  const double range = along - std::sqrt(inside);
  return beam.range > 0.0F && beam.range < range ? beam.range : static_cast<float>(range);
}

TEST(Localizer, IsNotPulledAlongACorridorByWhoWalksThere) {
  for (const double pace : {-1.2, 0.3}) {  // [m/s]
    Drive drive;
    drive.room = {.length = 80.0, .width = 2.0, .reach = 8.0, .range_sigma = 0.01};
    Eigen::Vector2d person(1.5, 0.4);
    drive.rearrange = [&](LaserScan& scan) {
      person.x() += 0.18 * pace;
      if (std::abs(person.x() - drive.truth.x) > 4.0) person.x() = drive.truth.x - std::copysign(3.0, pace);
      for (int i = 0; i < scan.size; ++i) {
        Beam& beam = scan.storage[static_cast<std::size_t>(i)];
        beam.range = behind(drive.truth, beam, person);
      }
    };
    drive.run(2.0, kStand);
    drive.run(40.0, {0.3, 0, 0});
    EXPECT_LT(drive.error(), 1.2) << pace << "; 12 m and more if each match is believed";
    EXPECT_GT(drive.localizer->counters().scans_held, 50U) << pace;
    EXPECT_EQ(drive.localizer->counters().wheels_withdrawn, 0U) << pace;
  }
}

TEST(Localizer, BelievesACorridorsEndWhereAWheelSlips) {
  for (const double side : {-1.0, 1.0}) {
    Drive drive;
    drive.imu = false;
    drive.room = {.length = 30.0, .width = 2.0, .reach = 20.0, .range_sigma = 0.01};
    drive.run(2.0, kStand);
    drive.run(6.0, {0.3, 0, 0});
    const std::uint32_t held = drive.localizer->counters().scans_held;
    for (int i = 0; i < 6; ++i) {
      drive.run(3.0, {0.3, 0, 0});
      drive.pretend({0.12, 0.0, 0.08 * side});
      drive.run(0.2, {0.3, 0, 0});
      EXPECT_LT(drive.error(), 0.1) << "after slip " << i;
    }
    EXPECT_EQ(drive.localizer->counters().scans_held, held);
  }
}

TEST(Localizer, NoisyWheelsTellLessOfTheWayAlongACorridor) {
  /// @return [m^2/m] variance of the way along the corridor, where the lidar did not see it
  const auto variance = [](double noise) {
    Drive drive;
    drive.imu = false;
    drive.room = {.length = 60.0, .width = 3.0, .reach = 12.0, .range_sigma = 0.01};
    drive.truth = {-28.0, 0.0, 0.0};
    std::mt19937 random(1);
    std::normal_distribution<double> normal;
    double sum = 0.0, way = 0.0;
    while (drive.truth.x < 5.0) {  // the first metres in sight of the corridor's end
      drive.pretend({noise * std::sqrt(0.05) * normal(random), 0.0, 0.0});
      drive.run(0.1, {0.5, 0.0, 0.0});
      const Keyframe* keyframe = drive.last.keyframe;
      if (keyframe == nullptr || keyframe->look || keyframe->observable == 3) continue;
      sum += keyframe->step_covariance(0, 0);
      way += keyframe->T_previous_base.x;
    }
    EXPECT_GT(way, 5.0) << "[m]";
    return sum / way;
  };
  const double good = variance(0.0), noisy = variance(0.2);
  EXPECT_GT(noisy, 1.5 * good);
  EXPECT_LT(noisy, 10.0 * good);
}

TEST(Localizer, StopsKeepingScansOfAKnownPlaceButGoesOnLooking) {
  Drive drive;
  drive.run(2.0, kStand);
  for (int lap = 0; lap < 4; ++lap) drive.run(16.0, kCurve);  // circles of 0.75 m radius
  const auto known = drive.localizer->counters().keyframes;
  bool looked = false;
  for (int step = 0; step < 160; ++step) {
    drive.run(0.2, kCurve);
    looked |= drive.last.keyframe != nullptr && drive.last.keyframe->look;
  }
  EXPECT_EQ(drive.localizer->counters().keyframes, known);
  EXPECT_TRUE(looked);
}

TEST(Localizer, IsDegradedWithoutLidarAndLocalisedAgainWithIt) {
  Drive drive;
  drive.run(2.0, kStand);
  drive.run(4.0, kCurve);
  drive.lidar = false;
  drive.run(3.0, kCurve);
  EXPECT_EQ(drive.state(), LocalisationState::kDegraded);
  EXPECT_LT(drive.error(), 0.15);
  drive.lidar = true;
  drive.run(2.0, kCurve);
  EXPECT_EQ(drive.state(), LocalisationState::kLocalised);
  EXPECT_LT(drive.error(), 0.04);
}

TEST(Localizer, AFailedMatchNeverMovesThePose) {
  Drive drive;
  drive.run(3.0, kStand);
  const Pose2 before = drive.localizer->estimate(drive.now).T_map_base;
  drive.room = {.length = 3.0, .width = 2.4, .range_sigma = 0.01};  // the lidar sees something else altogether
  drive.run(1.0, kStand);
  EXPECT_FALSE(drive.last.fused);
  const Pose2 moved = between(before, drive.localizer->estimate(drive.now).T_map_base);
  EXPECT_LT(std::hypot(moved.x, moved.y), 0.005);
  EXPECT_EQ(drive.state(), LocalisationState::kDegraded);
}

TEST(Localizer, IsInitialisingUntilAScanIsPlaced) {
  Drive drive;
  drive.lidar = false;
  drive.run(2.0, kStand);
  EXPECT_EQ(drive.state(), LocalisationState::kInitialising);
}

TEST(Localizer, JoinsOdomAndMap) {
  Drive drive;
  drive.run(2.0, kStand);
  drive.run(5.0, kCurve);
  const OdometryEstimate odometry = drive.localizer->odometry(drive.now);
  const Pose2 joined = odometry.T_map_odom * odometry.T_odom_base;
  const Pose2 error = between(drive.localizer->estimate(drive.now).T_map_base, joined);
  EXPECT_LT(std::hypot(error.x, error.y), 1e-9);
}

TEST(Localizer, SurvivesScansThatSayNothing) {
  Drive drive;
  drive.run(2.0, kStand);
  auto empty = std::make_unique<LaserScan>();
  empty->stamp = drive.now;
  for (int i = 0; i < 50; ++i) {
    EXPECT_FALSE(drive.localizer->add(*empty).fused);
    empty->stamp += 100ms;
  }
  drive.run(6.0, kStand);
  EXPECT_EQ(drive.state(), LocalisationState::kLocalised);
}

TEST(Localizer, IsNotBlindedByOneSampleFromTheFuture) {
  Drive drive;
  drive.run(2.0, kStand);
  drive.localizer->add(WheelSample{drive.now + 8s, {}});
  drive.localizer->add(ImuSample{drive.now + 24h, Eigen::Vector3d::Zero(), Eigen::Vector3d::Zero()});
  auto scan = std::make_unique<LaserScan>();
  scan->stamp = drive.now + 8s;
  drive.localizer->add(*scan);
  drive.run(5.0, kCurve);
  EXPECT_EQ(drive.state(), LocalisationState::kLocalised);
  EXPECT_LT(drive.error(), 0.03);
  EXPECT_EQ(drive.localizer->counters().far_ahead, 3U);
  EXPECT_EQ(drive.localizer->counters().scans_too_late, 0U);
}

TEST(Localizer, UsesNoReturnsOutsideTheLimitsOfTheConfiguration) {
  LocalizerConfig config;
  config.lidar.range_max = 1.0;  // no wall is that near
  Drive drive(config);
  drive.run(3.0, kStand);
  EXPECT_EQ(drive.state(), LocalisationState::kInitialising);
}

TEST(Localizer, CountsTimeThatWentBackAndGoesOn) {
  Drive drive;
  drive.run(3.0, kStand);
  drive.now -= 60s;   // the clock was set back
  drive.imu = false;  // (an IMU sample that old is dropped and counted)
  drive.run(3.0, kStand);
  EXPECT_GT(drive.localizer->counters().clock_resets, 0U);
  EXPECT_TRUE(drive.last.fused);
}

TEST(Localizer, DoesNotAllocateAfterStartUp) {
  Drive drive;
  drive.run(1.0, kStand);
  EXPECT_EQ(test::allocationsDuring([&] { drive.run(5.0, kCurve); }), 0U);
}

TEST(Localizer, AFastLidarIsNotLostBehindADoorSill) {
  Drive drive;
  drive.scan_every = 1;  // 50 Hz
  drive.run(4.0, {0.3, 0, 0.1});
  const test::Room room = drive.room;
  drive.room = {.length = 1.1, .width = 0.9};  // legs all around
  drive.run(0.5, {0.3, 0, 0.1});
  EXPECT_NE(drive.state(), LocalisationState::kLost);
  drive.room = room;
  drive.run(1.0, {0.3, 0, 0.1});
  EXPECT_EQ(drive.localizer->counters().lost, 0U);
  EXPECT_EQ(drive.state(), LocalisationState::kLocalised);
  EXPECT_LT(drive.error(), 0.05);
}

TEST(Localizer, KeepsUsingTheGyroWhenAllClocksAreSetBack) {
  Drive drive;
  drive.run(4.0, {0.3, 0, 0.3});
  drive.now -= 1h;
  drive.run(4.0, {0.3, 0, 0.3});
  EXPECT_EQ(drive.localizer->counters().samples_too_old, 0U);
}

TEST(Localizer, StampsBeforeAndBehindTheBeamsAreOne) {
  // The same turn, stamped at its first beam, at its last one, and with beams in the other order.
  std::array<Pose2, 3> poses;
  for (std::size_t i = 0; i < poses.size(); ++i) {
    Drive drive;
    drive.turning = true;
    drive.rearrange = [i](LaserScan& scan) {
      if (i == 1) {
        const float last = scan.beams().back().time_offset;
        scan.stamp += fromSeconds(last);
        for (int k = 0; k < scan.size; ++k) scan.storage[static_cast<std::size_t>(k)].time_offset -= last;
      }
      if (i == 2) std::reverse(scan.storage.begin(), scan.storage.begin() + scan.size);
    };
    drive.run(6.0, {0.3, 0, 0.6});
    EXPECT_LT(drive.error(), 0.03) << i;
    poses[i] = drive.localizer->estimate(drive.now).T_map_base;
  }
  for (const Pose2& pose : poses) EXPECT_LT(std::hypot(pose.x - poses[0].x, pose.y - poses[0].y), 0.005);
}

/// A drive whose map is then corrected as a back end would.
class CorrectedLocalizer : public testing::Test {
 protected:
  explicit CorrectedLocalizer(const LocalizerConfig& config = {}) : drive(config) {
    drive.keyframes = &graph;
    drive.run(2.0, kStand);
    drive.run(8.0, kCurve);
  }
  Pose2 estimate() const { return drive.localizer->estimate(drive.now).T_map_base; }
  /// The keyframes given, all moved alike.
  std::unique_ptr<MapCorrection> corrected(const std::vector<int>& ids, const Pose2& motion) {
    auto correction = std::make_unique<MapCorrection>(drive.localizer->config().reference);
    correction->reference.clear((motion * estimate()).translation());
    for (const int id : ids) {
      graph.points(id, points);
      correction->reference.add(motion * graph.pose(id), points);
      correction->keyframes.push_back({id, motion * graph.pose(id)});
    }
    correction->newest = ids.empty() ? -1 : ids.back();
    return correction;
  }
  std::vector<int> upTo(int newest) const {
    std::vector<int> ids(static_cast<std::size_t>(newest) + 1);
    std::iota(ids.begin(), ids.end(), 0);
    return ids;
  }
  int newest() const { return graph.size() - 1; }
  static double distance(const Pose2& a, const Pose2& b) { return std::hypot(a.x - b.x, a.y - b.y); }

  Drive drive;
  KeyframeGraph graph;
  ScanPoints points;
};

const Pose2 kMotion{0.6, -0.4, 0.3};

TEST_F(CorrectedLocalizer, MovesPoseAndKeyframesAsOne) {
  const PoseEstimate before = drive.localizer->estimate(drive.now);
  const Localizer::Anchored anchored = drive.localizer->anchor(before.T_map_base);
  ASSERT_GE(anchored.keyframe, 0);
  drive.localizer->apply(*corrected(upTo(newest()), kMotion));

  const PoseEstimate after = drive.localizer->estimate(drive.now);
  const Pose2 expected = kMotion * before.T_map_base;
  EXPECT_LT(distance(after.T_map_base, expected), 1e-9);
  EXPECT_NEAR(wrapAngle(after.T_map_base.theta - expected.theta), 0.0, 1e-9);
  EXPECT_NEAR(after.twist.vx, before.twist.vx, 1e-9);
  EXPECT_NEAR(after.covariance.trace(), before.covariance.trace(), 1e-12);
  Eigen::Matrix2d turn;
  turn << std::cos(kMotion.theta), -std::sin(kMotion.theta), std::sin(kMotion.theta), std::cos(kMotion.theta);
  const Eigen::Matrix2d turned = turn * before.covariance.topLeftCorner<2, 2>() * turn.transpose();
  EXPECT_LT((after.covariance.topLeftCorner<2, 2>() - turned).norm(), 1e-6 * turned.norm());

  const Localizer::Anchored same = drive.localizer->anchor(after.T_map_base);
  EXPECT_EQ(same.keyframe, anchored.keyframe);
  EXPECT_LT(distance(same.T_keyframe_base, anchored.T_keyframe_base), 1e-9);
}

TEST_F(CorrectedLocalizer, GoesOnMatchingInTheCorrectedMap) {
  for (const Pose2& motion : {kMotion, Pose2{-20.0, 35.0, 2.5}, Pose2{}}) {
    drive.localizer->apply(*corrected(upTo(newest()), motion));
    for (int id = 0; id < graph.size(); ++id) graph.graph().setPose(id, motion * graph.pose(id));
    const Pose2 T_map_world = estimate() * drive.truth.inverse();
    const LocalizerCounters before = drive.localizer->counters();
    drive.run(5.0, kCurve);
    EXPECT_LT(distance(estimate(), T_map_world * drive.truth), 0.04);
    EXPECT_EQ(drive.state(), LocalisationState::kLocalised);
    const LocalizerCounters after = drive.localizer->counters();
    EXPECT_GE(after.matched, before.matched + 25);
    EXPECT_EQ(after.unmatched + after.gated + after.searched, before.unmatched + before.gated + before.searched);
  }
}

TEST_F(CorrectedLocalizer, JumpsOnceInMapAndNeverInOdom) {
  const OdometryEstimate before = drive.localizer->odometry(drive.now);
  drive.localizer->apply(*corrected(upTo(newest()), kMotion));
  const OdometryEstimate after = drive.localizer->odometry(drive.now);
  EXPECT_EQ(after.T_odom_base, before.T_odom_base);
  EXPECT_EQ(after.covariance, before.covariance);
  EXPECT_LT(distance(after.T_map_odom, kMotion * before.T_map_odom), 1e-9);
  Pose2 odom = after.T_odom_base, map = estimate();
  for (int step = 0; step < 100; ++step) {
    drive.run(0.02, kCurve);
    const Pose2 next_odom = drive.localizer->odometry(drive.now).T_odom_base, next_map = estimate();
    ASSERT_LT(distance(odom, next_odom), 0.01) << step;
    ASSERT_LT(distance(map, next_map), 0.03) << step;
    odom = next_odom;
    map = next_map;
  }
}

TEST_F(CorrectedLocalizer, MovesLikeTheNearestKeyframe) {
  auto correction = corrected(upTo(newest()), {});
  const int nearest = drive.localizer->anchor(estimate()).keyframe;
  for (ReferenceKeyframe& keyframe : correction->keyframes) {
    keyframe.T_map_base = (keyframe.id == nearest ? kMotion : Pose2{5.0, 5.0, 1.0}) * keyframe.T_map_base;
  }
  const Pose2 expected = kMotion * estimate();
  drive.localizer->apply(*correction);
  EXPECT_LT(distance(estimate(), expected), 1e-9);
}

TEST_F(CorrectedLocalizer, KeepsKeyframesNewerThanTheCorrection) {
  const Pose2 last = graph.pose(newest());
  const auto surfels = corrected(upTo(newest()), kMotion)->reference.size();
  auto correction = corrected(upTo(newest() - 2), kMotion);
  const auto without = correction->reference.size();
  drive.localizer->apply(*correction);
  for (const int id : {newest() - 1, newest()}) {
    const Localizer::Anchored there = drive.localizer->anchor(kMotion * graph.pose(id));
    EXPECT_EQ(there.keyframe, id);
    EXPECT_LT(distance(there.T_keyframe_base, {}), 1e-9);
  }
  // Their points are in the reference, too: applied once more, it comes back.
  auto next = corrected(upTo(newest()), kMotion);
  drive.localizer->apply(*next);
  EXPECT_GE(next->reference.size(), without);
  EXPECT_EQ(next->reference.size(), surfels);
  EXPECT_EQ(next->keyframes.size(), static_cast<std::size_t>(graph.size()));

  // The next keyframe's step begins where the moved one lies.
  drive.keyframes = nullptr;
  drive.room = {.length = 9.0, .width = 6.0, .range_sigma = 0.01};  // all looks new, so one is kept
  const auto known = drive.localizer->counters().keyframes;
  while (drive.localizer->counters().keyframes == known && drive.now < Timestamp{200s}) drive.run(0.18, kCurve);
  ASSERT_NE(drive.last.keyframe, nullptr);
  const Pose2 expected = kMotion * last * drive.last.keyframe->T_previous_base;
  EXPECT_LT(distance(drive.last.keyframe->T_map_base, expected), 1e-9);
}

/// Each scan becomes a keyframe: many come while a correction is computed.
class DenselyKeptLocalizer : public CorrectedLocalizer {
 protected:
  static LocalizerConfig dense() {
    LocalizerConfig config;
    config.keyframe.translation = 0.01;
    config.keyframe.familiarity = 2.0;  // nothing is
    return config;
  }
  DenselyKeptLocalizer() : CorrectedLocalizer(dense()) { drive.run(8.0, kCurve); }
};

TEST_F(DenselyKeptLocalizer, KeepsSixAndAllThatCanBeAheadOfACorrection) {
  for (const int ahead : {6, Localizer::kMostAhead}) {
    ASSERT_GT(newest(), ahead) << "keyframes";
    const auto surfels = corrected(upTo(newest()), kMotion)->reference.size();
    auto correction = corrected(upTo(newest() - ahead), kMotion);
    EXPECT_EQ(test::allocationsDuring([&] { drive.localizer->apply(*correction); }), 0U);
    const auto held = drive.localizer->referenceKeyframes();
    ASSERT_EQ(held.size(), static_cast<std::size_t>(graph.size())) << ahead;
    for (int id = 0; id <= newest(); ++id) {
      const ReferenceKeyframe& keyframe = held[static_cast<std::size_t>(id)];
      EXPECT_EQ(keyframe.id, id) << ahead;
      EXPECT_LT(distance(keyframe.T_map_base, kMotion * graph.pose(id)), 1e-9) << ahead;
      EXPECT_EQ(drive.localizer->anchor(kMotion * graph.pose(id)).keyframe, id) << ahead;
    }
    for (int id = 0; id < graph.size(); ++id) graph.graph().setPose(id, kMotion * graph.pose(id));
    auto next = corrected(upTo(newest()), {});
    drive.localizer->apply(*next);
    EXPECT_EQ(next->reference.size(), surfels) << ahead << ": their points are in the reference, too";
  }
}

TEST_F(DenselyKeptLocalizer, WhatIsAheadHangsOnTheNewestThatTheCorrectionKnows) {
  // The back end has bent the map: each of its keyframes is moved otherwise.
  auto correction = corrected(upTo(newest() - 6), {});
  for (ReferenceKeyframe& keyframe : correction->keyframes) {
    keyframe.T_map_base = Pose2{0.001 * keyframe.id, 0.002 * keyframe.id, 0.0003 * keyframe.id} * keyframe.T_map_base;
  }
  const Pose2 T_new_old = correction->keyframes.back().T_map_base * graph.pose(correction->newest).inverse();
  const Pose2 expected = T_new_old * estimate();
  drive.localizer->apply(*correction);
  const auto held = drive.localizer->referenceKeyframes();
  ASSERT_EQ(held.size(), static_cast<std::size_t>(graph.size()));
  for (int id = newest() - 5; id <= newest(); ++id) {
    EXPECT_LT(distance(held[static_cast<std::size_t>(id)].T_map_base, T_new_old * graph.pose(id)), 1e-9);
  }
  EXPECT_LT(distance(estimate(), expected), 1e-9) << "the robot stays where it is among them";
}

TEST_F(CorrectedLocalizer, TakesTheCorrectionForNoDrift) {
  drive.localizer->apply(*corrected(upTo(newest()), {20.0, -30.0, 0.3}));
  drive.keyframes = nullptr;
  const auto known = drive.localizer->counters().keyframes;
  drive.room = {.length = 8.0, .width = 6.0, .range_sigma = 0.01};  // one wall looks new, so a keyframe is kept
  while (drive.localizer->counters().keyframes == known && drive.now < Timestamp{200s}) drive.run(0.18, kCurve);
  ASSERT_NE(drive.last.keyframe, nullptr);
  EXPECT_LT(std::sqrt(drive.last.keyframe->step_covariance(0, 0)), 0.03);
}

TEST_F(CorrectedLocalizer, ForgetsKeyframesThatTheCorrectionLeavesOut) {
  ASSERT_GT(newest(), 4);
  drive.localizer->apply(*corrected({newest() - 1, newest()}, {}));
  for (int id = 0; id < newest() - 1; ++id) EXPECT_GE(drive.localizer->anchor(graph.pose(id)).keyframe, newest() - 1);
}

TEST_F(CorrectedLocalizer, StaysWhereItIsWhenNoKeyframeIsCommon) {
  auto correction = corrected(upTo(newest()), kMotion);
  for (ReferenceKeyframe& keyframe : correction->keyframes) keyframe.id += 1000;
  correction->newest += 1000;
  const Pose2 before = estimate();
  drive.localizer->apply(*correction);
  EXPECT_LT(distance(estimate(), before), 1e-9);
}

TEST_F(CorrectedLocalizer, HandsBackTheOldReference) {
  auto correction = corrected(upTo(newest()), kMotion);
  drive.localizer->apply(*correction);
  ASSERT_EQ(correction->keyframes.size(), static_cast<std::size_t>(graph.size()));
  for (const ReferenceKeyframe& keyframe : correction->keyframes)
    EXPECT_LT(distance(keyframe.T_map_base, graph.pose(keyframe.id)), 1e-9);
}

TEST_F(CorrectedLocalizer, DoesNotAllocateForACorrection) {
  auto correction = corrected(upTo(newest() - 2), kMotion);
  drive.keyframes = nullptr;
  EXPECT_EQ(test::allocationsDuring([&] { drive.localizer->apply(*correction); }), 0U);
  const auto known = drive.localizer->counters().keyframes;
  drive.room = {.length = 9.0, .width = 6.0, .range_sigma = 0.01};  // all looks new
  EXPECT_EQ(test::allocationsDuring([&] { drive.run(10.0, kCurve); }), 0U);
  EXPECT_GT(drive.localizer->counters().keyframes, known + 3);
}

TEST_F(CorrectedLocalizer, AnchorsAPoseToTheNearestKeyframe) {
  const Localizer fresh{LocalizerConfig{}};
  EXPECT_EQ(fresh.anchor({}).keyframe, -1);
  for (int id = 0; id < graph.size(); ++id) {
    const Localizer::Anchored there = drive.localizer->anchor(graph.pose(id) * Pose2{0.001, 0.002, 0.5});
    EXPECT_EQ(there.keyframe, id);
    EXPECT_LT(distance(there.T_keyframe_base, {0.001, 0.002, 0.0}), 1e-9);
    EXPECT_NEAR(there.T_keyframe_base.theta, 0.5, 1e-9);
  }
}

}  // namespace
}  // namespace slam
