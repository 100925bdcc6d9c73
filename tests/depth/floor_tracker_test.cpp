// SPDX-License-Identifier: BSD-3-Clause
#include "depth/floor_tracker.hpp"

#include <Eigen/Geometry>
#include <gtest/gtest.h>
#include <random>

namespace slam::floor_tracker_test {
namespace {

using namespace std::chrono_literals;
constexpr double kHeight = 0.4;  // [m] of the camera

/// Points that a camera sees of a flat floor and a wall, thrown off by wrong extrinsics and noise.
class Scenery {
 public:
  /// A level camera before a wall.
  std::vector<Eigen::Vector3f> lookAtWall(double distance) {
    constexpr double kNearest = 0.95;  // [m] of the floor in view
    std::vector<Eigen::Vector3f> points;
    const double strip = distance - kNearest, floor_share = strip / (strip + 0.8);
    for (int i = 0; i < 1500; ++i) {
      const bool floor = i < 1500 * floor_share;
      const Eigen::Vector3d p(floor ? draw(kNearest, distance) : distance, draw(-0.5, 0.5),
                              floor ? 0.0 : draw(0.0, 0.8));
      const Eigen::Vector3d from_camera = p - Eigen::Vector3d(0.0, 0.0, kHeight);
      const double interval = 1.0 + 0.0015 * p.x() * normal_(random_);
      points.push_back((interval * from_camera + Eigen::Vector3d(0.0, 0.0, kHeight)).cast<float>());
    }
    return points;
  }
  /// @param pitch, roll [rad] of the true camera beyond what is believed; @param lift [m] of its true height
  std::vector<Eigen::Vector3f> look(double pitch, double roll, double lift, double floor_share = 0.6) {
    std::vector<Eigen::Vector3f> points;
    const Eigen::Matrix3d tilt =
        (Eigen::AngleAxisd(pitch, Eigen::Vector3d::UnitY()) * Eigen::AngleAxisd(roll, Eigen::Vector3d::UnitX()))
            .toRotationMatrix();
    for (int i = 0; i < 1500; ++i) {
      const bool floor = i < 1500 * floor_share;
      const Eigen::Vector3d p(floor ? draw(0.9, 3.5) : 3.6, draw(-1.5, 1.5), floor ? 0.0 : draw(0.0, 1.2));
      const Eigen::Vector3d from_camera = p - Eigen::Vector3d(0.0, 0.0, kHeight + lift);
      const double interval = 1.0 + 0.0015 * p.x() * normal_(random_);  // depth noise along the ray
      const Eigen::Vector3d believed = tilt.transpose() * (interval * from_camera);
      points.push_back((believed + Eigen::Vector3d(0.0, 0.0, kHeight)).cast<float>());
    }
    return points;
  }

 private:
  double draw(double low, double high) { return std::uniform_real_distribution<double>(low, high)(random_); }
  std::mt19937 random_{3};
  std::normal_distribution<double> normal_{0.0, 1.0};
};

TEST(FloorTracker, FindsASmallTiltAndHeightUnderNoise) {
  FloorTracker tracker({});
  Scenery scenery;
  Timestamp stamp{10s};
  for (int i = 0; i < 60; ++i, stamp += 33ms) {
    ASSERT_FALSE(tracker.update(stamp, scenery.look(0.02, -0.015, 0.01), kHeight));
  }
  // A camera that looks down by more than it believes sees the floor rise before it.
  EXPECT_NEAR(tracker.plane().slope_x, 0.02, 0.003);
  EXPECT_NEAR(tracker.plane().slope_y, 0.015, 0.003);  // its left side is down: the floor rises to the left
  for (const auto& p : scenery.look(0.02, -0.015, 0.01, 1.0)) {
    ASSERT_NEAR(p.z(), tracker.plane().height(p.x(), p.y()), 0.035);
  }
}

TEST(FloorTracker, FollowsARobotThatNods) {
  FloorTracker tracker({});
  Scenery scenery;
  Timestamp stamp{10s};
  double worst = 0.0;
  for (int i = 0; i < 200; ++i, stamp += 33ms) {
    const double pitch = 0.02 * std::sin(0.02 * i);
    tracker.update(stamp, scenery.look(pitch, 0.0, 0.0), kHeight);
    if (i > 20) worst = std::max(worst, std::abs(tracker.plane().slope_x - pitch));
  }
  EXPECT_LT(worst, 0.012);
}

TEST(FloorTracker, DoesNotCreepAwayBeforeAWall) {
  FloorTracker tracker({});
  Scenery scenery;
  Timestamp stamp{10s};
  for (int i = 0; i < 30; ++i, stamp += 33ms) tracker.update(stamp, scenery.look(0.005, 0.0, 0.0), kHeight);
  for (int i = 0; i < 450; ++i, stamp += 33ms) {  // the robot rolls up to it and stands there
    const double wall = std::max(1.05, 3.5 - 0.01 * i);
    ASSERT_FALSE(tracker.update(stamp, scenery.lookAtWall(wall), kHeight)) << wall;
    EXPECT_LT(tracker.plane().tilt(), 0.03) << wall;
    EXPECT_LT(std::abs(tracker.plane().height(wall, 0.0)), 0.025) << "[m]";
  }
  for (int i = 0; i < 30; ++i, stamp += 33ms) {  // and turns away
    ASSERT_FALSE(tracker.update(stamp, scenery.look(0.005, 0.0, 0.0), kHeight));
  }
  EXPECT_NEAR(tracker.plane().slope_x, 0.005, 0.004);
}

TEST(FloorTracker, FindsTheFloorAgainThatItHadLost) {
  for (const Duration period : {33ms, 333ms}) {
    SCOPED_TRACE(toSeconds(period));
    FloorTracker tracker({});
    Scenery scenery;
    Timestamp stamp{10s};
    for (int i = 0; i < 60; ++i, stamp += period) tracker.update(stamp, scenery.look(0.05, 0.0, 0.035), kHeight);
    ASSERT_GT(tracker.plane().tilt(), 0.03);
    int refused = 0;
    for (int i = 0; i < 30; ++i, stamp += period) {
      refused += tracker.update(stamp, scenery.look(-0.01, 0.0, 0.0), kHeight).has_value();
    }
    EXPECT_LT(refused, 5);
    EXPECT_NEAR(tracker.plane().slope_x, -0.01, 0.004);
  }
}

TEST(FloorTracker, NeverTakesACameraBeyondTheBoundForALevelOne) {
  for (const double pitch : {0.058, 0.063, 0.07, 0.09}) {
    FloorTracker tracker({});
    Scenery scenery;
    Timestamp stamp{10s};
    int told = 0;
    for (int i = 0; i < 60; ++i, stamp += 33ms) {
      told += tracker.update(stamp, scenery.look(pitch, 0.0, 0.0), kHeight).has_value();
    }
    // Told, or followed as far as it may be: then the floor is known to a centimetre a metre.
    EXPECT_TRUE(told > 30 || tracker.plane().slope_x > 0.045) << pitch << ": " << tracker.plane().slope_x;
  }
}

TEST(FloorTracker, StaysWithinItsBounds) {
  FloorTracker tracker({});
  Scenery scenery;
  Timestamp stamp{10s};
  for (int i = 0; i < 200; ++i, stamp += 33ms) tracker.update(stamp, scenery.look(0.0003 * i, 0.0, 0.0), kHeight);
  EXPECT_LE(tracker.plane().tilt(), FloorTrackerConfig{}.max_tilt + 1e-9);
}

TEST(FloorTracker, FollowsAHeightUpToItsBound) {
  for (const double lift : {0.03, -0.03, 0.055, -0.055}) {
    FloorTracker tracker({});
    Scenery scenery;
    Timestamp stamp{10s};
    for (int i = 0; i < 100; ++i, stamp += 33ms) {
      const double now = std::copysign(std::min(std::abs(lift), 0.001 * i), lift);
      tracker.update(stamp, scenery.look(0.0, 0.0, now), kHeight);
      ASSERT_LE(std::abs(tracker.plane().offset), FloorTrackerConfig{}.max_offset + 1e-9);
    }
    if (std::abs(lift) < 0.04) {
      EXPECT_NEAR(tracker.plane().offset, -lift, 0.008);
    }
  }
}

TEST(FloorTracker, FollowsNoFasterThanItSettles) {
  FloorTracker tracker({});
  Scenery scenery;
  Timestamp stamp{10s};
  for (int i = 0; i < 20; ++i) tracker.update(stamp += 30ms, scenery.look(0.0, 0.0, 0.0), kHeight);
  ASSERT_NEAR(tracker.plane().slope_x, 0.0, 0.004);
  tracker.update(stamp += 30ms, scenery.look(0.02, 0.0, 0.0), kHeight);
  EXPECT_NEAR(tracker.plane().slope_x, 0.1 * 0.02, 0.003);
  for (int i = 0; i < 30; ++i) tracker.update(stamp += 30ms, scenery.look(0.02, 0.0, 0.0), kHeight);
  EXPECT_NEAR(tracker.plane().slope_x, 0.02, 0.004);
}

TEST(FloorTracker, AStripThatMayBeAWallsFootMovesNothing) {
  FloorTracker tracker({});
  std::mt19937 random(1);
  std::uniform_real_distribution<float> metres(-0.5F, 0.5F);
  std::vector<Eigen::Vector3f> strip;
  for (int i = 0; i < 500; ++i) strip.emplace_back(1.0F + 0.04F * metres(random), metres(random), 0.018F);
  EXPECT_FALSE(tracker.update(Timestamp{10s}, strip, kHeight));
  EXPECT_EQ(tracker.plane().offset, 0.0);
  for (Eigen::Vector3f& p : strip) p.x() = 1.0F + 10.0F * (p.x() - 1.0F);  // a wider one does
  EXPECT_FALSE(tracker.update(Timestamp{11s}, strip, kHeight));
  EXPECT_GT(tracker.plane().offset, 0.005);
}

TEST(FloorTracker, ReportsTenDegreesTooMuchAndACameraOnItsHead) {
  Scenery scenery;
  for (int image = 0; image < 20; ++image) {  // the floor before a camera that looks down rises above it
    const double pitch = image % 2 == 0 ? 0.1745 : -0.1745;
    FloorTracker tracker({});
    const auto tilt = tracker.update(Timestamp{10s}, scenery.look(pitch, 0.0, 0.0), kHeight);
    ASSERT_TRUE(tilt) << pitch;
    EXPECT_NEAR(*tilt, 0.1745, 0.03) << image;
  }
  FloorTracker tracker({});
  const auto tilt = tracker.update(Timestamp{10s}, scenery.look(0.0, 3.14159, 0.0), kHeight);
  ASSERT_TRUE(tilt);
  EXPECT_GT(*tilt, 3.0);
}

TEST(FloorTracker, ADeskOrAWallIsNoFloor) {
  FloorTracker tracker({});
  std::mt19937 random(1);
  std::uniform_real_distribution<float> metres(-0.5F, 0.5F);
  std::vector<Eigen::Vector3f> desk, wall;
  for (int i = 0; i < 1000; ++i) {
    desk.emplace_back(1.5F + metres(random), metres(random), 0.72F);  // 0.32 m above the camera's height, but level
    wall.emplace_back(1.0F, metres(random), 0.4F + 0.6F * metres(random));
  }
  EXPECT_FALSE(tracker.update(Timestamp{10s}, wall, kHeight));
  EXPECT_EQ(tracker.plane().tilt(), 0.0);
  EXPECT_EQ(tracker.plane().offset, 0.0);
}

TEST(FloorTracker, FollowsAFewPointsNoFurtherThanItsBound) {
  for (const double lift : {0.06, -0.06}) {
    FloorTracker tracker({});
    Scenery scenery;
    Timestamp stamp{10s};
    for (int i = 0; i < 100; ++i, stamp += 33ms) {
      auto points = scenery.look(0.0, 0.0, std::copysign(std::min(std::abs(lift), 0.001 * i), lift), 1.0);
      points.resize(200);  // too few to look for a floor elsewhere
      ASSERT_FALSE(tracker.update(stamp, points, kHeight));
      ASSERT_LE(std::abs(tracker.plane().offset), FloorTrackerConfig{}.max_offset + 1e-9) << i;
    }
    EXPECT_NEAR(tracker.plane().offset, std::copysign(0.04, -lift), 1e-4);
  }
}

TEST(FloorTracker, ReportsAFloorThatLiesHigherOrLowerThanItCan) {
  for (const double lift : {0.10, -0.10}) {
    for (const double floor_share : {0.6, 1.0}) {
      FloorTracker tracker({});
      Scenery scenery;
      Timestamp stamp{10s};
      for (int i = 0; i < 5; ++i, stamp += 33ms) {
        EXPECT_TRUE(tracker.update(stamp, scenery.look(0.0, 0.0, lift, floor_share), kHeight)) << lift;
        EXPECT_EQ(tracker.plane().offset, 0.0) << "not followed";
      }
    }
  }
}

}  // namespace
}  // namespace slam::floor_tracker_test
