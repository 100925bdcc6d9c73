// SPDX-License-Identifier: BSD-3-Clause
#include "depth/depth_projection.hpp"

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <gtest/gtest.h>
#include <numbers>
#include <string>
#include <zlib.h>

#include "build_paths.hpp"
#include "support/allocations.hpp"
#include "tools/sim/depth/depth_camera.hpp"
#include "tools/sim/world/furniture.hpp"

namespace slam::depth_projection_test {
namespace {

using sim::DepthCamera;
constexpr double kDegree = std::numbers::pi / 180.0;
constexpr Timestamp kStart{std::chrono::seconds(100)};

DepthProjectionConfig mounted() {
  return {.extrinsics = {.x = DepthCamera::kExtrinsics.x, .z = DepthCamera::kHeight}, .floor = {}};
}

/// A simulated camera with all its errors, 10 cm ahead of the origin, in a room whose far wall is 3.4 m from it.
class Projection : public testing::Test {
 protected:
  Projection() { addRoom(world, -3.0, -3.0, 3.55, 3.0); }

  const DepthImage& look(const Pose2& pose = {}) {
    camera.capture(world, pose, frame_, kStart + frame_ * std::chrono::milliseconds(33), image);
    ++frame_;
    return image;
  }
  /// A projection that takes the median, with the images it needs for it.
  DepthProjection withMedian() {
    DepthProjectionConfig config = mounted();
    config.median = 3;
    DepthProjection projection(config);
    for (int i = 0; i < 3; ++i) EXPECT_EQ(projection.project(look()), DepthStatus::kOk);
    return projection;
  }
  const PseudoBeam& beamAt(const DepthProjection& projection, double bearing) {
    const PseudoLaser& laser = projection.laser();
    const auto i = std::lround((bearing - laser.bearing_min) / laser.bearing_step);
    return laser.storage[static_cast<std::size_t>(std::clamp<long>(i, 0, laser.size - 1))];
  }

  sim::World world;
  DepthCamera camera{640, 480, 1};
  DepthImage image;

 private:
  std::uint64_t frame_ = 0;
};

TEST_F(Projection, FindsTheWallAndTheFreeSpaceBeforeIt) {
  DepthProjection projection(mounted());
  for (int i = 0; i < 20; ++i) {
    ASSERT_EQ(projection.project(look()), DepthStatus::kOk);
    ASSERT_EQ(projection.laser().size, 118);
    for (int beam = 0; beam < projection.laser().size; ++beam) {
      const PseudoBeam& b = projection.laser().storage[static_cast<std::size_t>(beam)];
      const double expected = 3.4 / std::cos(projection.laser().bearing(beam));
      ASSERT_EQ(b.kind, PseudoBeam::Kind::kHit) << beam;
      ASSERT_NEAR(b.range, expected, 0.04) << beam;
      // Floor and the robot's top come into view where the field of view is 0.8 m high.
      ASSERT_NEAR(b.free_from, 1.0, 0.12) << beam;
    }
  }
}

TEST_F(Projection, DetectsATableByItsEdgeAndItsTopAsSurfaceBehind) {
  sim::addTable(world, 2.4, 0.0, 0.8, 1.6);  // from 1.9 m to 2.7 m ahead of the camera
  DepthProjection projection(mounted());
  for (int i = 0; i < 5; ++i) ASSERT_EQ(projection.project(look()), DepthStatus::kOk);
  EXPECT_EQ(beamAt(projection, 0.0).kind, PseudoBeam::Kind::kHit);
  EXPECT_NEAR(beamAt(projection, 0.0).range, 1.9, 0.06);
  double nearest = 10.0, farthest = 0.0;
  for (const PseudoLaser::Surface& surface : projection.laser().surfaces()) {
    const double bearing = projection.laser().bearing(surface.beam);
    if (std::abs(bearing) > 0.1 || surface.from > 3.0F) continue;
    nearest = std::min<double>(nearest, surface.from);
    farthest = std::max<double>(farthest, surface.to);
  }
  EXPECT_LT(nearest, 2.1);
  EXPECT_NEAR(farthest, 2.7, 0.1);
}

TEST_F(Projection, WhatBeginsAboveTheRobotIsDrivenUnder) {
  world.add(sim::Box{2.2, 0.0, 0.0, 0.6, 1.5, 0.9, 1.4});  // a shelf on the wall, 0.9 m above the floor
  DepthProjection projection(mounted());
  ASSERT_EQ(projection.project(look()), DepthStatus::kOk);
  EXPECT_NEAR(beamAt(projection, 0.0).range, 3.4, 0.05) << "the wall below the shelf";
  EXPECT_LT(beamAt(projection, 0.0).free_from, 1.2) << "the way under it is free";
}

TEST_F(Projection, WhatIsLowerThanTheClearanceIsDrivenOver) {
  world.add(sim::Box{2.2, 0.0, 0.0, 0.6, 1.5, 0.0, 0.02});  // a carpet
  DepthProjection projection(mounted());
  for (int i = 0; i < 10; ++i) ASSERT_EQ(projection.project(look()), DepthStatus::kOk);
  EXPECT_NEAR(beamAt(projection, 0.0).range, 3.4, 0.05);
}

TEST_F(Projection, NoReturnIsNeverFree) {
  DepthProjection projection(mounted());
  look();
  const int width = image.intrinsics.width;
  for (int v = 0; v < image.intrinsics.height; ++v) {  // the middle is a window pane: no depth at all
    std::fill_n(image.depth.begin() + v * width + width / 2 - 40, 80, 0);
  }
  ASSERT_EQ(projection.project(image), DepthStatus::kOk);
  EXPECT_EQ(beamAt(projection, 0.0).kind, PseudoBeam::Kind::kUnknown);
  EXPECT_EQ(beamAt(projection, 0.3).kind, PseudoBeam::Kind::kHit);
}

TEST_F(Projection, AThingInTheBlindZoneIsUnknownNotFree) {
  world.add(sim::Box{0.45, 0.0, 0.0, 0.2, 0.08, 0.0, 0.8});  // 0.25 m before the lens
  DepthProjection projection(mounted());
  ASSERT_EQ(projection.project(look()), DepthStatus::kOk);
  EXPECT_EQ(beamAt(projection, 0.0).kind, PseudoBeam::Kind::kUnknown);
}

TEST_F(Projection, FreeSpaceEndsWhereDepthIsMissingAtSomeHeight) {
  world.add(sim::Box{3.4, 0.0, 0.0, 0.1, 8.0, 0.0, 2.5});
  DepthProjection projection(mounted());
  look();
  const int width = image.intrinsics.width;
  // The rows that look level have no depth: they are between floor and top at every distance.
  for (int v = 225; v < 255; ++v) std::fill_n(image.depth.begin() + v * width, width, 0);
  ASSERT_EQ(projection.project(image), DepthStatus::kOk);
  const PseudoBeam& beam = beamAt(projection, 0.0);
  EXPECT_EQ(beam.kind, PseudoBeam::Kind::kHit) << "the wall is seen above and below";
  EXPECT_EQ(beam.free_from, beam.range) << "but nothing is known to be free before it";
}

TEST_F(Projection, ASmallTiltDoesNotMakeTheFloorAnObstacle) {
  for (const double pitch : {-2.0 * kDegree, 2.0 * kDegree}) {
    DepthProjectionConfig config = mounted();
    config.extrinsics.pitch = pitch;  // believed, while the camera looks level
    DepthProjection projection(config);
    for (int i = 0; i < 40; ++i) ASSERT_EQ(projection.project(look()), DepthStatus::kOk) << i;
    for (const double bearing : {-0.4, 0.0, 0.4}) {
      EXPECT_NEAR(beamAt(projection, bearing).range, 3.4 / std::cos(bearing), 0.06) << pitch;
    }
    EXPECT_NEAR(projection.floor().slope_x, -pitch, 0.01);
  }
}

TEST_F(Projection, RefusesImagesOfACameraThatHangsOtherwiseThanConfigured) {
  for (const double pitch : {-10.0 * kDegree, 10.0 * kDegree}) {
    DepthProjectionConfig config = mounted();
    config.extrinsics.pitch = pitch;
    DepthProjection projection(config);
    for (int i = 0; i < 10; ++i) EXPECT_NE(projection.project(look()), DepthStatus::kOk) << pitch;
  }
  DepthProjection upright(mounted());
  for (int i = 0; i < 10; ++i) {
    look();
    std::reverse(image.depth.begin(), image.depth.end());  // the camera upside down
    EXPECT_NE(upright.project(image), DepthStatus::kOk);
  }
  DepthProjectionConfig high = mounted();
  high.extrinsics.z = 0.6;
  DepthProjection projection(high);
  for (int i = 0; i < 10; ++i) EXPECT_NE(projection.project(look()), DepthStatus::kOk) << "0.2 m too high";
}

TEST_F(Projection, RefusesImagesWithoutDepthOrOfAWrongSize) {
  DepthProjection projection(mounted());
  ASSERT_EQ(projection.project(look()), DepthStatus::kOk);
  const PseudoLaser before = projection.laser();
  for (const int value : {0, 65535, 10001, 300}) {
    std::fill(image.depth.begin(), image.depth.end(), static_cast<std::uint16_t>(value));
    EXPECT_EQ(projection.project(image), DepthStatus::kNoDepth) << value;
  }
  image.depth.resize(image.depth.size() - 1);
  EXPECT_EQ(projection.project(image), DepthStatus::kWrongSize);
  EXPECT_EQ(projection.project({.stamp = kStart, .intrinsics = {}, .depth = {}}), DepthStatus::kWrongSize);
  EXPECT_EQ(projection.laser().size, before.size);
  EXPECT_EQ(projection.project(look()), DepthStatus::kOk) << "the next good image is used";
}

TEST_F(Projection, FollowsAChangeOfMode) {
  DepthProjection projection(mounted());
  ASSERT_EQ(projection.project(look()), DepthStatus::kOk);
  DepthCamera small(320, 240, 1);
  small.capture(world, {}, 0, kStart + std::chrono::seconds(1), image);
  ASSERT_EQ(projection.project(image), DepthStatus::kOk);
  EXPECT_NEAR(beamAt(projection, 0.0).range, 3.4, 0.05);
}

TEST_F(Projection, TheMedianLeavesOutWhatOneImageAloneShows) {
  DepthProjection projection = withMedian();
  look();
  const int width = image.intrinsics.width;
  for (int v = 200; v < 300; ++v) std::fill_n(image.depth.begin() + v * width + 300, 40, 1500);
  ASSERT_EQ(projection.project(image), DepthStatus::kOk);
  EXPECT_NEAR(beamAt(projection, 0.0).range, 3.4, 0.05);
  DepthProjection plain(mounted());
  ASSERT_EQ(plain.project(image), DepthStatus::kOk);
  EXPECT_NEAR(beamAt(plain, 0.0).range, 1.5, 0.05);
}

TEST_F(Projection, AllocatesNothingBehindTheFirstImage) {
  DepthProjection projection = withMedian();
  for (int i = 0; i < 5; ++i) {
    look();
    EXPECT_EQ(test::allocationsDuring([&] { projection.project(image); }), 0U);
  }
}

TEST(DepthProjection, NeedsAHeightAndABand) {
  EXPECT_THROW(DepthProjection({.extrinsics = {}, .floor = {}}), std::invalid_argument);
  EXPECT_THROW(DepthProjection({.extrinsics = {.z = 0.4}, .robot_height = 0.01, .floor = {}}), std::invalid_argument);
}

/// A Kinect's depth stills with the camera's poses (world: x right, y down, z forward, as the first camera roughly).
class KinectStills : public testing::Test {
 protected:
  void SetUp() override {
    const char* variable = std::getenv("SLAMD_DATA");
    folder = (variable != nullptr ? std::filesystem::path(variable)
                                  : std::filesystem::path(SLAMD_SOURCE_DIR) / "../shared/data") /
             "kinect_stills";
    if (!std::filesystem::exists(folder)) GTEST_SKIP() << folder << " is not there; set SLAMD_DATA";
  }
  DepthImage read(int number) const {
    const std::string file = folder / ("ch5_depth_" + std::to_string(number) + ".pgm.gz");
    DepthImage image{.stamp = kStart, .intrinsics = {640, 480, 518.0, 519.0, 325.5, 253.5}, .depth = {}};
    gzFile in = gzopen(file.c_str(), "rb");
    std::string bytes(1 << 20, '\0');
    const int size = in == nullptr ? 0 : gzread(in, bytes.data(), static_cast<unsigned>(bytes.size()));
    gzclose(in);
    const std::size_t data = 2 * image.intrinsics.pixels();
    if (size < static_cast<int>(data)) throw std::runtime_error(file + ": cannot be read");
    for (std::size_t i = static_cast<std::size_t>(size) - data; i < static_cast<std::size_t>(size); i += 2) {
      image.depth.push_back(static_cast<std::uint16_t>(static_cast<std::uint8_t>(bytes[i]) << 8 |
                                                       static_cast<std::uint8_t>(bytes[i + 1])));
    }
    return image;
  }
  std::filesystem::path folder;
};

TEST_F(KinectStills, OfOnePlaceAgreeInTheirHits) {
  std::ifstream poses(folder / "ch5_pose.txt");
  std::vector<std::vector<Eigen::Vector2d>> hits;
  for (int i = 1; i <= 5; ++i) {
    double x, y, z, qx, qy, qz, qw;
    ASSERT_TRUE(poses >> x >> y >> z >> qx >> qy >> qz >> qw);
    // To x forward, y left, z up, and there the angles that the extrinsics want.
    Eigen::Matrix3d to_body;
    to_body << 0, 0, 1, -1, 0, 0, 0, -1, 0;
    const Eigen::Matrix3d R =
        to_body * Eigen::Quaterniond(qw, qx, qy, qz).normalized().toRotationMatrix() * to_body.transpose();
    const double yaw = std::atan2(R(1, 0), R(0, 0)), pitch = -std::asin(R(2, 0)), roll = std::atan2(R(2, 1), R(2, 2));
    DepthProjectionConfig config{.extrinsics = {.z = 1.5 - y, .roll = roll, .pitch = pitch},
                                 .floor_clearance = 0.7,  // the floor is not level in these poses
                                 .robot_height = 1.9,
                                 .floor = {.min_points = 1 << 28}};
    DepthProjection projection(config);
    const DepthStatus status = projection.project(read(i));
    ASSERT_EQ(status, DepthStatus::kOk) << static_cast<int>(status);
    const Pose2 T_world_depth{z, -x, yaw};
    hits.emplace_back();
    for (int beam = 0; beam < projection.laser().size; ++beam) {
      const PseudoBeam& b = projection.laser().storage[static_cast<std::size_t>(beam)];
      const double bearing = projection.laser().bearing(beam);
      if (b.kind == PseudoBeam::Kind::kHit) {
        hits.back().push_back(T_world_depth *
                              Eigen::Vector2d(b.range * std::cos(bearing), b.range * std::sin(bearing)));
      }
    }
    EXPECT_GT(hits.back().size(), 60U) << "still " << i;
  }
  for (std::size_t i = 1; i < hits.size(); ++i) {
    std::vector<double> distances;
    for (const Eigen::Vector2d& hit : hits[i]) {
      double nearest = 1e9;
      for (const Eigen::Vector2d& other : hits[i - 1]) nearest = std::min(nearest, (hit - other).norm());
      distances.push_back(nearest);
    }
    // The camera moved on by up to 0.7 m and turned by up to 25 degrees: part of the hits is of the same things.
    const auto near = std::count_if(distances.begin(), distances.end(), [](double d) { return d < 0.10; });
    EXPECT_GT(near, static_cast<long>(distances.size()) * 3 / 10) << "stills " << i << " and " << i + 1;
  }
}

}  // namespace
}  // namespace slam::depth_projection_test
