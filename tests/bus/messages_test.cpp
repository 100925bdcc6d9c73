// SPDX-License-Identifier: BSD-3-Clause
#include "bus/messages.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <limits>
#include <memory>
#include <numbers>
#include <tuple>
#include <type_traits>
#include <vector>

#include "bus/checked_decode.hpp"
#include "bus/encoding.hpp"

namespace slam::messages_test {
namespace {

using test::encoded;

constexpr double kPi = std::numbers::pi;
constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
constexpr std::int64_t kUtime = 1'700'000'000'123'456;
constexpr int kLargestMessage = 65'499;  // [bytes] bigger ones are lost by Debian's liblcm at times

LaserScan scanOf(int beams) {
  LaserScan scan;
  scan.stamp = fromMicroseconds(kUtime);
  for (int i = 0; i < beams; ++i) {
    const float step = static_cast<float>(i) / static_cast<float>(beams);
    scan.push({.range = 1.0F + step, .bearing = 6.0F * step - 3.0F, .time_offset = 0.1F * step, .intensity = 10.0F});
  }
  return scan;
}

template <typename Sample>
auto throughTheWire(const Sample& sample) {
  const auto message = toMessage(sample, kUtime);
  const auto decoded = decodeChecked<std::remove_const_t<decltype(message)>>(encoded(message));
  return decoded ? fromMessage(*decoded) : std::nullopt;
}

PoseEstimate somePose() {
  PoseEstimate estimate;
  estimate.T_map_base = {1.0, -2.0, kPi / 2};
  estimate.covariance << 1, 2, 3, 2, 5, 6, 3, 6, 9;
  estimate.twist = {0.5, 0.1, -0.3};
  estimate.state = LocalisationState::kDegraded;
  estimate.match_quality = 0.75;
  return estimate;
}

OccupancyGrid gridWithOneWallPoint() {
  auto keyframe = std::make_unique<Keyframe>();
  keyframe->T_map_base = {0.525, 0.525, 0.0};
  keyframe->storage[0] = {2.0F, 0.0F};
  keyframe->size = 1;
  OccupancyGrid grid;
  grid.add(*keyframe);
  return grid;
}

TEST(ScanMessage, BringsAScanThroughTheWireUnchanged) {
  const LaserScan scan = scanOf(360);
  const auto back = throughTheWire(scan);
  ASSERT_TRUE(back);
  EXPECT_EQ(back->stamp, fromMicroseconds(kUtime));
  EXPECT_EQ(back->range_min, scan.range_min);
  EXPECT_EQ(back->range_max, scan.range_max);
  ASSERT_EQ(back->size, scan.size);
  for (int i = 0; i < scan.size; ++i) {
    const Beam &a = scan.beams()[static_cast<std::size_t>(i)], &b = back->beams()[static_cast<std::size_t>(i)];
    EXPECT_EQ(std::tie(a.range, a.bearing, a.time_offset, a.intensity),
              std::tie(b.range, b.bearing, b.time_offset, b.intensity));
  }
}

TEST(ScanMessage, OfTheLargestScanFitsOneDatagram) {
  EXPECT_LT(toMessage(scanOf(LaserScan::kCapacity), kUtime).getEncodedSize(), kLargestMessage);
}

TEST(ScanMessage, OfNoBeamsIsAScan) { EXPECT_TRUE(throughTheWire(scanOf(0))); }

TEST(ScanMessage, BadBeamsBecomeNoReturnAndTheOthersStay) {
  scan_t message = toMessage(scanOf(8), kUtime);
  message.ranges[1] = std::numeric_limits<float>::quiet_NaN();
  message.ranges[2] = std::numeric_limits<float>::infinity();
  message.ranges[3] = -1.0F;
  message.bearings[4] = std::numeric_limits<float>::quiet_NaN();
  message.time_offsets[5] = std::numeric_limits<float>::infinity();
  const auto scan = fromMessage(message);
  ASSERT_TRUE(scan);
  int returns = 0;
  for (const Beam& beam : scan->beams()) {
    EXPECT_TRUE(std::isfinite(beam.range) && std::isfinite(beam.bearing) && std::isfinite(beam.time_offset));
    returns += scan->isReturn(beam);
  }
  EXPECT_EQ(returns, 3);
}

TEST(ScanMessage, ThatCannotBeAScanIsRefused) {
  const auto refuses = [](auto&& spoil) {
    scan_t message = toMessage(scanOf(8), kUtime);
    spoil(message);
    return !fromMessage(message).has_value();
  };
  EXPECT_TRUE(refuses([](scan_t& m) { m.utime = 0; }));
  EXPECT_TRUE(refuses([](scan_t& m) { m.utime = std::numeric_limits<std::int64_t>::max(); }));
  EXPECT_TRUE(refuses([](scan_t& m) { m.range_min = std::numeric_limits<float>::quiet_NaN(); }));
  EXPECT_TRUE(refuses([](scan_t& m) { m.range_max = std::numeric_limits<float>::infinity(); }));
}

TEST(WheelsMessage, BringsASampleThroughTheWireUnchanged) {
  for (const bool turn_rate_known : {true, false}) {
    const WheelSample sample{.stamp = {}, .T_wheels_base = {1.0, -2.0, 0.5}, .turn_rate_known = turn_rate_known};
    const auto back = throughTheWire(sample);
    ASSERT_TRUE(back);
    EXPECT_EQ(back->stamp, fromMicroseconds(kUtime));
    EXPECT_EQ(back->T_wheels_base, sample.T_wheels_base);
    EXPECT_EQ(back->turn_rate_known, turn_rate_known);
  }
}

TEST(WheelsMessage, CarriesTheAnglesOfTheWheels) {
  const std::vector<double> angles = {1.5, -2.5};
  const auto message = decodeChecked<wheels_t>(encoded(toMessage(WheelSample{}, kUtime, angles)));
  ASSERT_TRUE(message);
  EXPECT_EQ(message->angles, angles);
}

TEST(WheelsMessage, ThatCannotBeAMeasurementIsRefused) {
  wheels_t message = toMessage(WheelSample{}, kUtime);
  ASSERT_TRUE(fromMessage(message));
  EXPECT_FALSE(fromMessage(toMessage(WheelSample{}, 0)));
  message.theta = kNaN;
  EXPECT_FALSE(fromMessage(message));
}

TEST(ImuMessage, BringsASampleThroughTheWireUnchanged) {
  const ImuSample sample{.stamp = {}, .gyro = {0.1, -0.2, 0.3}, .accel = {1.0, 2.0, 9.81}};
  const auto back = throughTheWire(sample);
  ASSERT_TRUE(back);
  EXPECT_EQ(back->stamp, fromMicroseconds(kUtime));
  EXPECT_EQ(back->gyro, sample.gyro);
  EXPECT_EQ(back->accel, sample.accel);
}

TEST(ImuMessage, ThatCannotBeAMeasurementIsRefused) {
  EXPECT_FALSE(fromMessage(toMessage(ImuSample{}, 0)));
  EXPECT_FALSE(fromMessage(toMessage(ImuSample{.stamp = {}, .gyro = {0, 0, kNaN}}, kUtime)));
  EXPECT_FALSE(fromMessage(toMessage(ImuSample{.stamp = {}, .gyro = {0, 0, 0}, .accel = {HUGE_VAL, 0, 0}}, kUtime)));
}

TEST(PoseMessage, IsWhatViewersOfBotCoreExpect) {
  const bot_core::pose_t message = toPoseMessage(somePose(), kUtime);
  EXPECT_EQ(message.utime, kUtime);
  EXPECT_THAT(message.pos, testing::ElementsAre(1.0, -2.0, 0.0));
  const double half = std::sqrt(0.5);  // a quarter turn: w, x, y, z
  EXPECT_THAT(message.orientation, testing::Pointwise(testing::DoubleNear(1e-12), {half, 0.0, 0.0, half}));
  EXPECT_THAT(message.vel, testing::Pointwise(testing::DoubleNear(1e-12), {-0.1, 0.5, 0.0}));  // in map axes
  EXPECT_THAT(message.rotation_rate, testing::Pointwise(testing::DoubleNear(1e-12), {0.0, 0.0, -0.3}));
  EXPECT_THAT(message.accel, testing::Each(0.0));
}

TEST(PoseEstimateMessage, CarriesEveryField) {
  const pose_estimate_t message = toMessage(somePose(), kUtime, 7);
  EXPECT_EQ(message.utime, kUtime);
  EXPECT_EQ(message.map_id, 7);
  EXPECT_EQ((Pose2{message.x, message.y, message.theta}), somePose().T_map_base);
  EXPECT_THAT(message.covariance, testing::ElementsAre(1, 2, 3, 2, 5, 6, 3, 6, 9));
  EXPECT_THAT(message.twist, testing::ElementsAre(0.5, 0.1, -0.3));
  EXPECT_EQ(message.state, 2);
  EXPECT_FLOAT_EQ(message.match_quality, 0.75F);
}

TEST(OdometryMessage, CarriesEveryField) {
  OdometryEstimate estimate;
  estimate.T_odom_base = {1, 2, 0.3};
  estimate.covariance << 1, 2, 3, 2, 5, 6, 3, 6, 9;
  estimate.twist = {0.5, 0.1, -0.3};
  estimate.gyro_bias = 0.01;
  estimate.slip = true;
  estimate.T_map_odom = {4, 5, 0.6};
  const odometry_t message = toMessage(estimate, kUtime);
  EXPECT_EQ(message.utime, kUtime);
  EXPECT_EQ((Pose2{message.x, message.y, message.theta}), estimate.T_odom_base);
  EXPECT_THAT(message.covariance, testing::ElementsAre(1, 2, 3, 2, 5, 6, 3, 6, 9));
  EXPECT_THAT(message.twist, testing::ElementsAre(0.5, 0.1, -0.3));
  EXPECT_EQ(message.gyro_bias, 0.01);
  EXPECT_TRUE(message.slip);
  EXPECT_FALSE(message.standstill);
  EXPECT_THAT(message.map_odom, testing::ElementsAre(4, 5, 0.6));
}

TEST(LaserMessage, ShowsTheNearestReturnOfEachBearingStep) {
  LaserScan scan;
  const float bearing = 0.3F;
  scan.push({.range = 5.0F, .bearing = bearing});
  scan.push({.range = 3.0F, .bearing = bearing});
  scan.push({.range = 0.0F, .bearing = bearing});                                 // no return says nothing
  scan.push({.range = 4.0F, .bearing = -2.0F + 2.0F * static_cast<float>(kPi)});  // the same bearing as -2
  scan.push({.range = 2.0F * scan.range_max, .bearing = 1.5F});                   // not trusted
  const bot_core::planar_lidar_t message = toLaserMessage(scan, kUtime, 360);
  EXPECT_EQ(message.utime, kUtime);
  ASSERT_EQ(message.nranges, 360);
  ASSERT_EQ(message.ranges.size(), 360U);
  EXPECT_EQ(message.intensities.size(), static_cast<std::size_t>(message.nintensities));
  EXPECT_NEAR(message.radstep, 2 * kPi / 360, 1e-6);
  const auto rangeAt = [&](double angle) {
    const auto step = static_cast<int>(std::lround(std::remainder(angle - message.rad0, 2 * kPi) / message.radstep));
    return message.ranges[static_cast<std::size_t>((step + 360) % 360)];
  };
  EXPECT_FLOAT_EQ(rangeAt(0.3), 3.0F);
  EXPECT_FLOAT_EQ(rangeAt(-2.0), 4.0F);
  EXPECT_EQ(std::count(message.ranges.begin(), message.ranges.end(), 0.0F), 358);
}

TEST(LaserMessage, OfTheLargestScanFitsOneDatagram) {
  EXPECT_LT(toLaserMessage(scanOf(LaserScan::kCapacity), kUtime).getEncodedSize(), kLargestMessage);
}

TEST(MapMessages, OfAnEmptyGridHoldNothing) {
  const map_meta_t meta = toMetaMessage(OccupancyGrid{}, kUtime, 3, 0);
  EXPECT_EQ(meta.tiles, 0);
  EXPECT_EQ(meta.map_id, 3);
  EXPECT_EQ(meta.resolution, OccupancyGridConfig{}.resolution);
  const map_tile_t tile = toTileMessage(OccupancyGrid{}, {0, 0}, kUtime, 3);
  EXPECT_THAT(tile.cells, testing::Each(std::uint8_t{255}));
}

TEST(MapMessages, ShowTheCellsOfTheGrid) {
  const OccupancyGrid grid = gridWithOneWallPoint();
  const map_meta_t meta = toMetaMessage(grid, kUtime, 3, 1);
  EXPECT_EQ(meta.tile_side, OccupancyGrid::kTileSide);
  EXPECT_THAT(meta.origin, testing::Each(0.0));
  EXPECT_EQ(meta.tiles, 1);
  EXPECT_EQ(meta.keyframes, 1);
  EXPECT_EQ((std::vector{meta.column_min, meta.column_max, meta.row_min, meta.row_max}), std::vector(4, 0));

  const map_tile_t tile = toTileMessage(grid, {0, 0}, kUtime, 3);
  EXPECT_LT(tile.getEncodedSize(), kLargestMessage);
  ASSERT_EQ(tile.ncells, tile.side * tile.side);
  const auto cell = [&](double x, double y) {
    const CellIndex at = grid.cellAt({x, y});
    return tile.cells[static_cast<std::size_t>(at.row * tile.side + at.column)];
  };
  EXPECT_EQ(cell(2.525, 0.525), 70);  // one look: hit_probability
  EXPECT_EQ(cell(1.525, 0.525), 33);  // miss_probability
  EXPECT_EQ(cell(0.525, 2.525), 255);
}

TEST(MapMessages, ShowOneLayerWithoutTheOther) {
  OccupancyGrid grid;
  grid.set({1, 0}, toLogOdds(0.9));
  grid.set({2, 0}, toLogOdds(0.2), toLogOdds(0.8));
  grid.set({3, 0}, 0, toLogOdds(0.3));
  const auto row = [&](MapLayer layer) {
    const auto cells = toTileMessage(grid, {0, 0}, kUtime, 3, layer).cells;
    return std::vector<int>(cells.begin(), cells.begin() + 4);
  };
  EXPECT_THAT(row(MapLayer::kBoth), testing::ElementsAre(255, 90, 80, 30));
  EXPECT_THAT(row(MapLayer::kLidar), testing::ElementsAre(255, 90, 20, 255));
  EXPECT_THAT(row(MapLayer::kDepth), testing::ElementsAre(255, 255, 80, 30));
}

TEST(MapMessages, NameTilesLeftAndBelowOfTheOrigin) {
  auto keyframe = std::make_unique<Keyframe>();
  keyframe->T_map_base = {-0.5, -0.5, 0.0};
  keyframe->storage[0] = {-1.0F, 0.0F};
  keyframe->size = 1;
  OccupancyGrid grid;
  grid.add(*keyframe);
  const map_meta_t meta = toMetaMessage(grid, kUtime, 3, 1);
  EXPECT_EQ((std::vector{meta.column_min, meta.column_max, meta.row_min, meta.row_max}), std::vector(4, -1));
  const map_tile_t tile = toTileMessage(grid, {-1, -1}, kUtime, 3);
  EXPECT_EQ(tile.column, -1);
  EXPECT_EQ(tile.row, -1);
  EXPECT_THAT(tile.cells, testing::Contains(std::uint8_t{70}));
}

TEST(Messages, APseudoLaserComesBackAsItWasAndHostileBeamsBecomeUnknown) {
  PseudoLaser laser;
  laser.stamp = fromMicroseconds(1'700'000'000'000'000);
  laser.bearing_min = -0.5F;
  laser.bearing_step = 0.01F;
  laser.size = 3;
  laser.storage[0] = {PseudoBeam::Kind::kHit, 2.0F, 1.0F};
  laser.storage[1] = {PseudoBeam::Kind::kFree, 4.0F, 1.0F};
  laser.push({0, 2.2F, 2.8F});
  depth_t message = toMessage(laser, 1'700'000'000'000'000);
  auto back = fromMessage(message);
  ASSERT_TRUE(back);
  EXPECT_EQ(back->stamp, laser.stamp);
  EXPECT_EQ(back->size, 3);
  EXPECT_EQ(back->storage[0].kind, PseudoBeam::Kind::kHit);
  EXPECT_EQ(back->storage[1].range, 4.0F);
  EXPECT_EQ(back->storage[2].kind, PseudoBeam::Kind::kUnknown);
  ASSERT_EQ(back->surface_count, 1);
  EXPECT_EQ(back->surfaces()[0].to, 2.8F);

  message.ranges = {std::numeric_limits<float>::quiet_NaN(), 1e30F, -1.0F};
  message.kinds = {2, 2, 1};
  message.surface_beams = {77};
  back = fromMessage(message);
  ASSERT_TRUE(back);
  for (const PseudoBeam& beam : back->beams()) EXPECT_EQ(beam.kind, PseudoBeam::Kind::kUnknown);
  EXPECT_EQ(back->surface_count, 0);
  message.bearing_step = std::numeric_limits<float>::infinity();
  EXPECT_FALSE(fromMessage(message));
  message.bearing_step = 0.01F;
  message.utime = 0;
  EXPECT_FALSE(fromMessage(message));
}

TEST(PoseMessage, TurnsBothSpeedsIntoTheMapsAxes) {
  PoseEstimate estimate = somePose();
  estimate.T_map_base.theta = kPi / 6;
  estimate.twist = {2.0, 1.0, 0.0};
  const bot_core::pose_t message = toPoseMessage(estimate, kUtime);
  EXPECT_NEAR(message.vel[0], 2.0 * std::sqrt(0.75) - 0.5, 1e-12);
  EXPECT_NEAR(message.vel[1], 1.0 + std::sqrt(0.75), 1e-12);
}

TEST(LaserMessage, HasTheIntensityOfTheReturnThatItShows) {
  LaserScan scan;
  scan.push({.range = 5.0F, .bearing = 0.3F, .time_offset = 0.0F, .intensity = 20.0F});
  scan.push({.range = 3.0F, .bearing = 0.3F, .time_offset = 0.0F, .intensity = 40.0F});
  scan.push({.range = 4.0F, .bearing = 0.3F, .time_offset = 0.0F, .intensity = 30.0F});
  const bot_core::planar_lidar_t message = toLaserMessage(scan, kUtime, 360);
  const auto shown = std::find(message.ranges.begin(), message.ranges.end(), 3.0F) - message.ranges.begin();
  ASSERT_LT(shown, 360);
  EXPECT_EQ(message.intensities[static_cast<std::size_t>(shown)], 40.0F);
  EXPECT_EQ(std::count(message.intensities.begin(), message.intensities.end(), 0.0F), 359);
}

}  // namespace
}  // namespace slam::messages_test
