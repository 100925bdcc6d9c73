// SPDX-License-Identifier: BSD-3-Clause
// From a depth image to the cells of the map: a camera that looks anywhere, on a robot that stands anywhere, and things
// that no mirror image of themselves can be taken for.
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <gtest/gtest.h>
#include <memory>
#include <numbers>
#include <ostream>
#include <vector>

#include "core/depth_view.hpp"
#include "depth/depth_projection.hpp"
#include "mapping/occupancy_grid.hpp"
#include "tools/sim/depth/depth_errors.hpp"
#include "tools/sim/depth/depth_renderer.hpp"
#include "tools/sim/world/world.hpp"

namespace slam::depth_geometry_test {
namespace {

constexpr double kDegree = std::numbers::pi / 180.0;

/// A camera with all its errors, on a robot.
class MountedCamera {
 public:
  explicit MountedCamera(const DepthExtrinsics& mounted)
      : mounted_(mounted),
        renderer_(DepthIntrinsics::fromFieldOfView(320, 240, 1.0226, 0.7966)),
        errors_(renderer_.intrinsics(), {}, 1),
        inverse_depth_(renderer_.intrinsics().pixels()) {}

  const DepthImage& look(const sim::World& world, const Pose2& T_world_base) {
    const Pose2 T_world_camera = T_world_base * Pose2{mounted_.x, mounted_.y, mounted_.yaw};
    Eigen::Matrix3d optical;  // x right, y down, z forward, seen from x forward, y left, z up
    optical << 0, 0, 1, -1, 0, 0, 0, -1, 0;
    Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
    T.translation() << T_world_camera.x, T_world_camera.y, mounted_.z;
    T.linear() = Eigen::AngleAxisd(T_world_camera.theta, Eigen::Vector3d::UnitZ()) *
                 Eigen::AngleAxisd(mounted_.pitch, Eigen::Vector3d::UnitY()) *
                 Eigen::AngleAxisd(mounted_.roll, Eigen::Vector3d::UnitX()) * optical;
    renderer_.render(world, T, inverse_depth_);
    image_.stamp += std::chrono::milliseconds(100);
    image_.intrinsics = renderer_.intrinsics();
    image_.depth.resize(image_.intrinsics.pixels());
    errors_.apply(inverse_depth_, frame_++, image_.depth);
    return image_;
  }

 private:
  DepthExtrinsics mounted_;
  sim::DepthRenderer renderer_;
  sim::DepthErrors errors_;
  std::vector<float> inverse_depth_;
  DepthImage image_;
  std::uint64_t frame_ = 0;
};

/// How the camera is mounted, and where the robot stands.
struct Setup {
  const char* name;
  DepthExtrinsics mounted;
  Pose2 T_map_base;
};
void PrintTo(const Setup& setup, std::ostream* out) { *out << setup.name; }

class DepthGeometry : public testing::TestWithParam<Setup> {
 protected:
  /// A place in front of the levelled camera, in map.
  Eigen::Vector2d ahead(double forward, double left) const {
    return GetParam().T_map_base * GetParam().mounted.levelled() * Eigen::Vector2d(forward, left);
  }
  void put(double forward, double left, double radius) {
    const Eigen::Vector2d at = ahead(forward, left);
    world.add(sim::Cylinder{at.x(), at.y(), radius, 0.0, 1.2});
  }
  sim::World world;
};

TEST_P(DepthGeometry, DrawsAThingWhereItStandsAndNothingWhereItsMirrorImageWould) {
  put(1.6, 0.55, 0.08);
  put(2.4, -0.35, 0.12);
  put(3.0, 0.35, 0.10);
  world.addWall(ahead(3.8, -3.0), ahead(3.8, 3.0));
  MountedCamera camera(GetParam().mounted);
  DepthProjection projection({.extrinsics = GetParam().mounted});
  OccupancyGrid grid({.resolution = 0.05});
  for (int i = 0; i < 10; ++i) {
    const DepthStatus status = projection.project(camera.look(world, GetParam().T_map_base));
    ASSERT_EQ(status, DepthStatus::kOk) << static_cast<int>(status);
    const DepthView view(projection.laser(), GetParam().mounted.levelled());
    grid.add(GetParam().T_map_base * view.T_base_depth, view);
  }
  const auto near = [&](const Eigen::Vector2d& at, int reach, auto&& wanted) {
    const CellIndex middle = grid.cellAt(at);
    int found = 0;
    for (int row = -reach; row <= reach; ++row) {
      for (int column = -reach; column <= reach; ++column)
        found += wanted(grid.logOdds({middle.column + column, middle.row + row}));
    }
    return found;
  };
  const auto occupied = [](LogOdds value) { return value > 0; };
  const auto free = [](LogOdds value) { return value < 0; };
  EXPECT_GE(near(ahead(1.6 - 0.08, 0.55), 1, occupied), 2);
  EXPECT_GE(near(ahead(2.4 - 0.12, -0.35), 1, occupied), 2);
  EXPECT_GE(near(ahead(3.0 - 0.10, 0.35), 1, occupied), 2);
  EXPECT_EQ(near(ahead(1.6, -0.55), 2, occupied), 0) << "mirrored";
  EXPECT_EQ(near(ahead(2.4, 0.35), 2, occupied), 0) << "mirrored";
  EXPECT_EQ(near(ahead(3.0, -0.35), 2, occupied), 0) << "mirrored";
  EXPECT_GE(near(ahead(1.6, -0.55), 1, free), 8) << "that way is free";
  EXPECT_GE(near(ahead(2.0, -0.30), 1, free), 8) << "before the second post";
  EXPECT_EQ(near(ahead(2.8, -0.41), 1, free), 0) << "behind it nothing is known";
  EXPECT_EQ(near(ahead(2.6, 1.75), 1, free), 0) << "outside of what the camera sees";
}

INSTANTIATE_TEST_SUITE_P(
    Of, DepthGeometry,
    testing::Values(Setup{"Ahead", {.x = 0.1, .z = 0.4}, {}},
                    Setup{"RobotTurned", {.x = 0.1, .z = 0.4}, {1.3, -2.2, 2.1}},
                    Setup{"CameraAside", {.x = 0.1, .y = 0.35, .z = 0.4}, {0.4, 0.7, -0.8}},
                    Setup{"CameraTurnedLeft", {.x = 0.15, .y = -0.1, .z = 0.45, .yaw = 0.7}, {-0.6, 1.1, 0.9}},
                    Setup{"CameraTurnedRight", {.x = -0.1, .y = 0.2, .z = 0.35, .yaw = -1.4}, {2.0, 0.3, -2.6}},
                    Setup{"CameraLooksDown", {.x = 0.1, .z = 0.6, .pitch = 12 * kDegree}, {0.5, 0.5, 0.4}},
                    Setup{"RightSideDown", {.x = 0.1, .z = 0.4, .roll = 15 * kDegree}, {0.5, 0.5, 0.4}},
                    Setup{"LeftSideDown", {.x = 0.1, .z = 0.4, .roll = -15 * kDegree}, {0.5, 0.5, 0.4}},
                    Setup{"All",
                          {.x = 0.12, .y = -0.08, .z = 0.5, .roll = -8 * kDegree, .pitch = 7 * kDegree, .yaw = 0.4},
                          {-1.2, 0.8, 1.9}}),
    [](const auto& setup) { return std::string(setup.param.name); });

/// A camera whose bracket gives way by an angle that the configuration does not know.
class BentBracket : public testing::TestWithParam<double> {};

TEST_P(BentBracket, ToOneSideIsFoundInTheFloorAndHidesNothing) {
  const DepthExtrinsics believed{.x = 0.1, .z = 0.4};
  DepthExtrinsics mounted = believed;
  mounted.roll = GetParam();
  sim::World world;
  world.addWall({3.35, -4.0}, {3.35, 4.0});
  MountedCamera camera(mounted);
  DepthProjection projection({.extrinsics = believed});
  for (int i = 0; i < 15; ++i) ASSERT_EQ(projection.project(camera.look(world, {})), DepthStatus::kOk);
  EXPECT_NEAR(projection.floor().slope_y, -GetParam(), 0.012);  // right side down: the floor falls to the left
  EXPECT_NEAR(projection.floor().slope_x, 0.0, 0.010);
  const PseudoLaser& laser = projection.laser();
  int beams = 0;
  for (int beam = 0; beam < laser.size; ++beam) {
    const double bearing = laser.bearing(beam);
    if (std::abs(bearing) > 0.45) continue;
    ++beams;
    const PseudoBeam& b = laser.storage[static_cast<std::size_t>(beam)];
    EXPECT_EQ(b.kind, PseudoBeam::Kind::kHit) << bearing;
    EXPECT_NEAR(b.range, 3.2 / std::cos(bearing), 0.08) << bearing;
  }
  EXPECT_GT(beams, 80);
}

INSTANTIATE_TEST_SUITE_P(By, BentBracket, testing::Values(2.4 * kDegree, -2.4 * kDegree));

/// A sill that is a little higher than what is driven over, to the left or to the right of the camera's axis.
TEST(DepthProjectionBeside, ASillIsAnObstacleOnItsSideAlone) {
  for (const double side : {1.0, -1.0}) {
    sim::World world;
    world.addWall({3.85, -4.0}, {3.85, 4.0});
    world.add(sim::Box{2.0, 0.5 * side, 0.0, 0.3, 0.6, 0.0, 0.10});
    MountedCamera camera({.x = 0.1, .z = 0.4});
    DepthProjection projection({.extrinsics = {.x = 0.1, .z = 0.4}});
    for (int i = 0; i < 5; ++i) ASSERT_EQ(projection.project(camera.look(world, {})), DepthStatus::kOk);
    const PseudoLaser& laser = projection.laser();
    for (int beam = 0; beam < laser.size; ++beam) {
      const double bearing = laser.bearing(beam), range = laser.storage[static_cast<std::size_t>(beam)].range;
      if (std::abs(bearing - 0.26 * side) < 0.1) {
        EXPECT_NEAR(range, 1.75 / std::cos(bearing), 0.08) << bearing;
      } else if (std::abs(bearing + 0.26 * side) < 0.1) {
        EXPECT_GT(range, 3.5) << bearing;
      }
    }
  }
}

/// A camera that hangs 3 cm higher, or lower, than configured: heights count from the floor that it sees.
TEST(DepthProjectionBeside, AFloorThatLiesLowerOrHigherThanConfiguredIsWhatHeightsCountFrom) {
  const auto rangeBefore = [](double camera, double sill) {
    sim::World world;
    world.addWall({3.85, -4.0}, {3.85, 4.0});
    world.add(sim::Box{1.9, 0.0, 0.0, 0.4, 1.0, 0.0, sill});
    MountedCamera mounted({.x = 0.1, .z = camera});
    DepthProjection projection({.extrinsics = {.x = 0.1, .z = 0.40}});
    for (int i = 0; i < 15; ++i) EXPECT_EQ(projection.project(mounted.look(world, {})), DepthStatus::kOk);
    EXPECT_NEAR(projection.floor().offset, 0.40 - camera, 0.012);
    return projection.laser().storage[static_cast<std::size_t>(projection.laser().size / 2)].range;
  };
  EXPECT_NEAR(rangeBefore(0.43, 0.075), 1.6, 0.08) << "7.5 cm above the floor, 4.5 cm above where it should be";
  EXPECT_GT(rangeBefore(0.37, 0.022), 3.5) << "2.2 cm above the floor, 5.2 cm above where it should be";
}

TEST(DepthProjectionBeside, WhatIsNearerThanIsTrustedIsNoObstacle) {
  sim::World world;
  world.addWall({3.85, -4.0}, {3.85, 4.0});
  MountedCamera camera({.x = 0.1, .z = 0.4});
  DepthProjection projection({.extrinsics = {.x = 0.1, .z = 0.4}});
  DepthImage image = camera.look(world, {});
  for (int v = 60; v < 180; ++v) std::fill_n(image.depth.begin() + v * 320 + 150, 20, 480);
  ASSERT_EQ(projection.project(image), DepthStatus::kOk);
  const PseudoLaser& laser = projection.laser();
  EXPECT_NE(laser.storage[static_cast<std::size_t>(laser.size / 2)].kind, PseudoBeam::Kind::kFree);
  for (const PseudoBeam& beam : laser.beams()) {
    if (beam.kind == PseudoBeam::Kind::kHit) {
      EXPECT_GT(beam.range, 3.0F);
    }
  }
}

TEST(OccupancyGridBeside, ADepthViewIsDrawnAlongItsBearingsAndTheRobotsHeading) {
  OccupancyGrid grid({.resolution = 0.1});
  DepthView view;
  const double heading = 0.9, left = 0.4, right = -0.3;
  view.beams.push_back({static_cast<float>(left), 2.0F, 1.0F, true});
  view.beams.push_back({static_cast<float>(right), 3.0F, 0.5F, false});
  view.surfaces.push_back({static_cast<float>(left), 2.6F, 2.8F});
  const Pose2 T_map_depth{1.05, -0.45, heading};
  grid.add(T_map_depth, view);
  const auto at = [&](double bearing, double range) {
    return grid.logOdds(
        grid.cellAt(T_map_depth * Eigen::Vector2d(range * std::cos(bearing), range * std::sin(bearing))));
  };
  EXPECT_GT(at(left, 2.0), 0);
  EXPECT_LT(at(left, 1.5), 0);
  EXPECT_EQ(at(left, 0.7), 0) << "nearer than free_from";
  EXPECT_EQ(at(left, 2.3), 0);
  EXPECT_GT(at(left, 2.7), 0);
  EXPECT_LT(at(right, 2.5), 0);
  EXPECT_EQ(at(right, 3.3), 0);
  EXPECT_EQ(at(-left, 2.0), 0) << "mirrored";
  EXPECT_EQ(at(-right, 1.5), 0) << "mirrored";
}

TEST(DepthRaysBeside, BeamsCountFromRightToLeftWhereTheirPixelsLook) {
  const DepthIntrinsics xtion = DepthIntrinsics::fromFieldOfView(320, 240, 1.0226, 0.7966);
  DepthRays rays;
  rays.prepare({.x = 0.1, .z = 0.4}, xtion, 0.0087, 1024);
  EXPECT_NEAR(rays.bearingMin(), -0.5 * 1.0226, 0.02);
  EXPECT_GT(rays.bearingStep(), 0.0F);
  for (const int u : {20, 100, 159, 200, 300}) {
    const auto beam = rays.pixel(static_cast<std::size_t>(120 * xtion.width + u)).beam;
    const double expected = std::atan2(xtion.cx - u, xtion.fx);  // counter-clockwise
    EXPECT_NEAR(rays.bearingMin() + beam * rays.bearingStep(), expected, 0.006) << u;
    EXPECT_NEAR(rays.cosine(beam), std::cos(expected), 0.006) << u;
    EXPECT_NEAR(rays.sine(beam), std::sin(expected), 0.006) << u;
  }
}

TEST(DepthRaysBeside, ACameraIsRolledAboutItsOwnPitchedAxis) {
  const DepthIntrinsics xtion = DepthIntrinsics::fromFieldOfView(320, 240, 1.0226, 0.7966);
  DepthRays rays;
  rays.prepare({.x = 0.1, .z = 0.4, .roll = 0.5, .pitch = 0.4}, xtion, 0.0087, 1024);
  const auto& middle = rays.pixel(static_cast<std::size_t>(120 * xtion.width + 160));
  EXPECT_NEAR(middle.up, -std::sin(0.4), 0.005);
  EXPECT_NEAR(rays.bearingMin() + middle.beam * rays.bearingStep(), 0.0, 0.01);
}

TEST(DepthRaysBeside, ARolledCameraIsLevelled) {
  const DepthIntrinsics xtion = DepthIntrinsics::fromFieldOfView(320, 240, 1.0226, 0.7966);
  DepthRays rays;
  rays.prepare({.x = 0.1, .z = 0.4, .roll = 0.2}, xtion, 0.0087, 1024);
  // Its right side is down: what lies in the middle row on the right is below the horizon, on the left above it.
  EXPECT_NEAR(rays.pixel(static_cast<std::size_t>(120 * xtion.width + 300)).up,
              std::sin(0.2) * (xtion.cx - 300) / xtion.fx, 0.01);
  EXPECT_GT(rays.pixel(static_cast<std::size_t>(120 * xtion.width + 20)).up, 0.05F);
}

/// A camera before stairs that lead down, along a share of its view.
TEST(DepthProjectionBeside, StairsDownAreNoFaultButAHoleWhereTheFloorShouldBeIs) {
  const auto statusAt = [](double share) {
    const DepthExtrinsics mounted{.x = 0.1, .z = 0.4};
    DepthProjection projection({.extrinsics = mounted});
    DepthImage image;
    image.intrinsics = DepthIntrinsics::fromFieldOfView(320, 240, 1.0226, 0.7966);
    image.depth.assign(image.intrinsics.pixels(), 0);
    for (int v = 0; v < 240; ++v) {
      const double down = (v - image.intrinsics.cy) / image.intrinsics.fy;
      for (int u = 0; u < 320; ++u) {
        const bool floor = u >= share * 320;
        const double depth = down > 0.02 ? (floor ? mounted.z : mounted.z + 0.5) / down : 9.0;  // [m]
        if (depth < 5.0) image.depth[static_cast<std::size_t>(v * 320 + u)] = static_cast<std::uint16_t>(1e3 * depth);
      }
    }
    DepthStatus status{};
    for (int i = 0; i < 5; ++i) {
      image.stamp += std::chrono::milliseconds(100);
      status = projection.project(image);
    }
    return status;
  };
  EXPECT_EQ(statusAt(0.0), DepthStatus::kOk);
  EXPECT_EQ(statusAt(0.1), DepthStatus::kOk);
  EXPECT_EQ(statusAt(0.3), DepthStatus::kBelowFloor);
}

}  // namespace
}  // namespace slam::depth_geometry_test
