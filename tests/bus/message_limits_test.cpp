// SPDX-License-Identifier: BSD-3-Clause
// Each limit that fromMessage() holds a message to, on both of its sides, and every field on its way.
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <functional>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <limits>
#include <memory>
#include <string>
#include <vector>

#include "bus/checked_decode.hpp"
#include "bus/encoding.hpp"
#include "bus/messages.hpp"
#include "core/plausibility.hpp"
#include "support/absurd.hpp"

namespace slam::message_limits_test {
namespace {

constexpr std::int64_t kUtime = 1'700'000'000'123'456;
constexpr std::int64_t kLastUtime = std::numeric_limits<std::int64_t>::max() / 4000 - 1;
constexpr double kNaN = std::numeric_limits<double>::quiet_NaN(), kInfinity = HUGE_VAL;

scan_t someScan() {
  LaserScan scan;
  scan.range_min = 0.15F;
  scan.range_max = 12.0F;
  for (const float bearing : {-2.0F, 0.5F, 2.0F}) scan.push({.range = 2.0F, .bearing = bearing, .time_offset = 0.01F});
  return toMessage(scan, kUtime);
}

depth_t someDepth() {
  PseudoLaser laser;
  laser.bearing_min = -0.3F;
  laser.bearing_step = 0.02F;
  laser.size = 3;
  laser.storage[0] = {PseudoBeam::Kind::kHit, 2.0F, 1.0F};
  laser.storage[1] = {PseudoBeam::Kind::kFree, 4.0F, 1.5F};
  laser.push({2, 2.2F, 2.8F});
  return toMessage(laser, kUtime);
}

/// A change of a good message, and whether the message is still taken.
template <typename Message>
struct Limit {
  const char* what;
  std::function<void(Message&)> change;
  bool taken;
};

template <typename Message>
void expectLimits(const Message& good, const std::vector<Limit<Message>>& limits) {
  ASSERT_TRUE(fromMessage(good));
  for (const auto& limit : limits) {
    Message message = good;
    limit.change(message);
    EXPECT_EQ(fromMessage(message).has_value(), limit.taken) << limit.what;
  }
  for (const auto& [utime, taken] :
       {std::pair(std::int64_t{1}, true), {0, false}, {-1, false}, {kLastUtime, true}, {kLastUtime + 1, false}}) {
    Message message = good;
    message.utime = utime;
    EXPECT_EQ(fromMessage(message).has_value(), taken) << "utime " << utime;
  }
}

TEST(MessageLimits, OfAScan) {
  const auto resize = [](scan_t& m, int beams) {
    m.nbeams = beams;
    for (auto* values : {&m.ranges, &m.bearings, &m.time_offsets, &m.intensities})
      values->resize(static_cast<std::size_t>(beams), 1.0F);
  };
  expectLimits<scan_t>(someScan(), {{"range_min 0", [](scan_t& m) { m.range_min = 0.0F; }, true},
                                    {"range_min below 0", [](scan_t& m) { m.range_min = -0.01F; }, false},
                                    {"range_min NaN", [](scan_t& m) { m.range_min = NAN; }, false},
                                    {"range_max above range_min", [](scan_t& m) { m.range_max = 0.16F; }, true},
                                    {"range_max at range_min", [](scan_t& m) { m.range_max = 0.15F; }, false},
                                    {"range_max NaN", [](scan_t& m) { m.range_max = NAN; }, false},
                                    {"range_max infinite", [](scan_t& m) { m.range_max = INFINITY; }, false},
                                    {"full", [&](scan_t& m) { resize(m, LaserScan::kCapacity); }, true},
                                    {"one more", [&](scan_t& m) { resize(m, LaserScan::kCapacity + 1); }, true},
                                    {"range_max not given", [](scan_t& m) { m.range_max = 0.0F; }, true},
                                    {"range_max below 0", [](scan_t& m) { m.range_max = -0.01F; }, false}});
}

TEST(MessageLimits, OfABeamMakeItNoReturnWhereItStands) {
  const auto beamOf = [](const std::function<void(scan_t&)>& change) {
    scan_t message = someScan();
    change(message);
    const auto scan = fromMessage(message);
    EXPECT_TRUE(scan);
    EXPECT_EQ(scan->beams()[0].range, 2.0F) << "its neighbours stay";
    EXPECT_EQ(scan->beams()[2].bearing, 2.0F);
    return scan->beams()[1];
  };
  for (const float offset : {9.99F, -9.99F}) {
    EXPECT_EQ(beamOf([&](scan_t& m) { m.time_offsets[1] = offset; }).time_offset, offset);
    EXPECT_EQ(beamOf([&](scan_t& m) { m.time_offsets[1] = 1.002F * offset; }).range, 0.0F);
    EXPECT_EQ(beamOf([&](scan_t& m) { m.time_offsets[1] = 1.002F * offset; }).time_offset, 0.0F);
  }
  EXPECT_EQ(beamOf([](scan_t& m) { m.bearings[1] = INFINITY; }).bearing, 0.0F);
  EXPECT_EQ(beamOf([](scan_t& m) { m.ranges[1] = -0.1F; }).range, 0.0F);
  EXPECT_EQ(beamOf([](scan_t& m) { m.ranges[1] = -0.1F; }).bearing, 0.5F) << "it still looks there";
  EXPECT_EQ(beamOf([](scan_t& m) { m.ranges[1] = NAN; }).range, 0.0F);
}

TEST(MessageLimits, OfWheelsAndImuAreThoseOfWhatCanBe) {
  WheelSample wheels;
  wheels.T_wheels_base = {1.0, 2.0, 0.5};
  for (const double bad : test::absurdNumbers(kPlausible.dead_reckoned)) {
    expectLimits<wheels_t>(toMessage(wheels, kUtime), {{"x", [&](wheels_t& m) { m.x = bad; }, false},
                                                       {"y", [&](wheels_t& m) { m.y = bad; }, false},
                                                       {"theta", [&](wheels_t& m) { m.theta = bad; }, false}});
  }
  for (int axis = 0; axis < 3; ++axis) {
    for (const double bad : test::absurdNumbers(kPlausible.turn_rate))
      expectLimits<imu_t>(toMessage(ImuSample{}, kUtime), {{"gyro", [&](imu_t& m) { m.gyro[axis] = bad; }, false}});
    for (const double bad : test::absurdNumbers(kPlausible.acceleration))
      expectLimits<imu_t>(toMessage(ImuSample{}, kUtime), {{"accel", [&](imu_t& m) { m.accel[axis] = bad; }, false}});
  }
  const auto at = [](double limit) {
    return std::vector<Limit<wheels_t>>{{"x", [=](wheels_t& m) { m.x = limit; }, true}};
  };
  expectLimits<wheels_t>(toMessage(wheels, kUtime), at(kPlausible.dead_reckoned));
}

TEST(MessageLimits, OfSpeedsAreThatEachNumberIsFinite) {
  drive_t drive{};
  drive.utime = kUtime;
  drive.vx = 0.5;
  for (const double bad : {kNaN, kInfinity, -kInfinity}) {
    expectLimits<drive_t>(drive, {{"vx", [&](drive_t& m) { m.vx = bad; }, false},
                                  {"vy", [&](drive_t& m) { m.vy = bad; }, false},
                                  {"omega", [&](drive_t& m) { m.omega = bad; }, false}});
  }
}

TEST(MessageLimits, ASpeedArrivesInItsDirections) {
  drive_t drive{};
  drive.utime = kUtime;
  drive.vx = 0.5;
  drive.vy = -0.25;
  drive.omega = 0.75;
  const auto twist = fromMessage(*decodeChecked<drive_t>(test::encoded(drive)));
  ASSERT_TRUE(twist);
  EXPECT_EQ(twist->vx, 0.5);
  EXPECT_EQ(twist->vy, -0.25);
  EXPECT_EQ(twist->omega, 0.75);
}

TEST(MessageLimits, OfADepthView) {
  const auto resize = [](depth_t& m, int beams) {
    m.nbeams = beams;
    m.ranges.resize(static_cast<std::size_t>(beams), 1.0F);
    m.free_from.resize(static_cast<std::size_t>(beams), 1.0F);
    m.kinds.resize(static_cast<std::size_t>(beams), 1);
  };
  expectLimits<depth_t>(someDepth(), {{"bearing_min", [](depth_t& m) { m.bearing_min = 9.99F; }, true},
                                      {"-bearing_min", [](depth_t& m) { m.bearing_min = -9.99F; }, true},
                                      {"bearing_min 10", [](depth_t& m) { m.bearing_min = 10.0F; }, false},
                                      {"bearing_min -10", [](depth_t& m) { m.bearing_min = -10.0F; }, false},
                                      {"bearing_min NaN", [](depth_t& m) { m.bearing_min = NAN; }, false},
                                      {"bearing_step", [](depth_t& m) { m.bearing_step = 0.99F; }, true},
                                      {"bearing_step, clockwise", [](depth_t& m) { m.bearing_step = -0.99F; }, true},
                                      {"bearing_step 1", [](depth_t& m) { m.bearing_step = 1.0F; }, false},
                                      {"bearing_step -1", [](depth_t& m) { m.bearing_step = -1.0F; }, false},
                                      {"bearing_step NaN", [](depth_t& m) { m.bearing_step = NAN; }, false},
                                      {"full", [&](depth_t& m) { resize(m, PseudoLaser::kCapacity); }, true},
                                      {"one more", [&](depth_t& m) { resize(m, PseudoLaser::kCapacity + 1); }, false}});
}

TEST(MessageLimits, OfADepthBeamMakeItUnknown) {
  const auto kindOf = [](float range, float from, std::int8_t kind) {
    depth_t message = someDepth();
    message.ranges[0] = range;
    message.free_from[0] = from;
    message.kinds[0] = kind;
    const auto laser = fromMessage(message);
    EXPECT_TRUE(laser);
    EXPECT_EQ(laser->beams()[1].range, 4.0F);
    return laser->beams()[0].kind;
  };
  constexpr auto kUnknown = PseudoBeam::Kind::kUnknown, kHit = PseudoBeam::Kind::kHit;
  EXPECT_EQ(kindOf(99.9F, 1.0F, 2), kHit);
  EXPECT_EQ(kindOf(100.0F, 1.0F, 2), kUnknown);
  EXPECT_EQ(kindOf(0.01F, 0.0F, 2), kHit);
  EXPECT_EQ(kindOf(0.0F, 0.0F, 2), kUnknown);
  EXPECT_EQ(kindOf(2.0F, 2.0F, 2), kHit) << "nothing before it is free";
  EXPECT_EQ(kindOf(2.0F, 2.01F, 2), kUnknown);
  EXPECT_EQ(kindOf(2.0F, -0.01F, 2), kUnknown);
  EXPECT_EQ(kindOf(2.0F, NAN, 2), kUnknown);
  EXPECT_EQ(kindOf(2.0F, 1.0F, 1), PseudoBeam::Kind::kFree);
  EXPECT_EQ(kindOf(2.0F, 1.0F, 0), kUnknown);
  EXPECT_EQ(kindOf(2.0F, 1.0F, 3), kUnknown);
  EXPECT_EQ(kindOf(2.0F, 1.0F, -1), kUnknown);
}

TEST(MessageLimits, OfASurfaceLeaveItOut) {
  const auto surfaces = [](std::int16_t beam, float from, float to) {
    depth_t message = someDepth();
    message.surface_beams[0] = beam;
    message.surface_from[0] = from;
    message.surface_to[0] = to;
    return fromMessage(message)->surface_count;
  };
  EXPECT_EQ(surfaces(0, 2.2F, 2.8F), 1);
  EXPECT_EQ(surfaces(2, 2.2F, 2.8F), 1);
  EXPECT_EQ(surfaces(3, 2.2F, 2.8F), 0) << "there is no such beam";
  EXPECT_EQ(surfaces(-1, 2.2F, 2.8F), 0);
  EXPECT_EQ(surfaces(2, 0.01F, 2.8F), 1);
  EXPECT_EQ(surfaces(2, 0.0F, 2.8F), 0);
  EXPECT_EQ(surfaces(2, 2.2F, 2.2F), 1);
  EXPECT_EQ(surfaces(2, 2.2F, 2.19F), 0);
  EXPECT_EQ(surfaces(2, 2.2F, 99.9F), 1);
  EXPECT_EQ(surfaces(2, 2.2F, 100.0F), 0);
  EXPECT_EQ(surfaces(2, NAN, 2.8F), 0);
}

TEST(DepthMessage, CarriesEveryField) {
  const auto message = decodeChecked<depth_t>(test::encoded(someDepth()));
  ASSERT_TRUE(message);
  const auto laser = fromMessage(*message);
  ASSERT_TRUE(laser);
  EXPECT_EQ(laser->stamp, fromMicroseconds(kUtime));
  EXPECT_EQ(laser->bearing_min, -0.3F);
  EXPECT_EQ(laser->bearing_step, 0.02F);
  ASSERT_EQ(laser->size, 3);
  const auto expectBeam = [&](std::size_t i, PseudoBeam::Kind kind, float range, float from) {
    EXPECT_EQ(laser->storage[i].kind, kind) << i;
    EXPECT_EQ(laser->storage[i].range, range) << i;
    EXPECT_EQ(laser->storage[i].free_from, from) << i;
  };
  expectBeam(0, PseudoBeam::Kind::kHit, 2.0F, 1.0F);
  expectBeam(1, PseudoBeam::Kind::kFree, 4.0F, 1.5F);
  expectBeam(2, PseudoBeam::Kind::kUnknown, 0.0F, 0.0F);
  ASSERT_EQ(laser->surface_count, 1);
  EXPECT_EQ(laser->surfaces()[0].beam, 2);
  EXPECT_EQ(laser->surfaces()[0].from, 2.2F);
  EXPECT_EQ(laser->surfaces()[0].to, 2.8F);
}

TEST(MapMessages, KeepColumnsAndRowsApart) {
  OccupancyGrid grid;
  const double tile = grid.resolution() * OccupancyGrid::kTileSide;
  for (const auto& [column, row] : {std::pair(2, -1), {5, 3}, {4, 0}}) {
    auto keyframe = std::make_unique<Keyframe>();
    keyframe->T_map_base = {(column + 0.25) * tile, (row + 0.5) * tile, 0.0};
    keyframe->storage[0] = {0.02F, 0.0F};
    keyframe->size = 1;
    grid.add(*keyframe);
  }
  const map_meta_t meta = toMetaMessage(grid, kUtime, 3, 7);
  EXPECT_EQ(meta.utime, kUtime);
  EXPECT_EQ(meta.tiles, 3);
  EXPECT_EQ(meta.keyframes, 7);
  EXPECT_EQ((std::vector{meta.column_min, meta.column_max, meta.row_min, meta.row_max}), (std::vector{2, 5, -1, 3}));
  const map_tile_t message = toTileMessage(grid, {5, 3}, kUtime, 9);
  EXPECT_EQ(message.utime, kUtime);
  EXPECT_EQ(message.map_id, 9);
  EXPECT_EQ(message.column, 5);
  EXPECT_EQ(message.row, 3);
  EXPECT_EQ(message.side, OccupancyGrid::kTileSide);
  const auto drawn = std::find_if(message.cells.begin(), message.cells.end(), [](auto cell) { return cell != 255; });
  const auto place = static_cast<int>(drawn - message.cells.begin());
  EXPECT_EQ(place / OccupancyGrid::kTileSide, OccupancyGrid::kTileSide / 2) << "row by row";
  EXPECT_NEAR(place % OccupancyGrid::kTileSide, OccupancyGrid::kTileSide / 4, 1);
}

}  // namespace
}  // namespace slam::message_limits_test
