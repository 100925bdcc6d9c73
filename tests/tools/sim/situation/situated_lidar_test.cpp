// SPDX-License-Identifier: BSD-3-Clause
#include "tools/sim/situation/situated_lidar.hpp"

#include <cmath>
#include <gtest/gtest.h>

#include "tools/sim/world/furniture.hpp"

namespace slam::sim::situated_lidar_test {
namespace {

constexpr double kPi = 3.14159265358979323846;

World room() {
  World world;
  addRoom(world, -5.0, -4.0, 5.0, 4.0);
  return world;
}

Situation with(std::initializer_list<const char*> kinds) {
  Situation situation;
  for (const char* kind : kinds) addTo(situation, kind);
  return situation;
}

TEST(SituatedLidar, WithoutASituationMeasuresAsTheModelDoes) {
  const World world = room();
  SituatedLidar lidar(world, {}, 7);
  LidarModel model(world, {}, 7);
  const Pose2 pose{1.0, -0.5, 0.7};
  for (int i = 0; i < 720; ++i) {
    const double bearing = wrapAngle(-2.0 * kPi * (i % 360) / 360);
    const auto look = lidar.look(pose, i % 360, false);
    EXPECT_EQ(look.beam.range, static_cast<float>(model.measure(pose, bearing)));
    EXPECT_EQ(look.beam.bearing, static_cast<float>(bearing));
    EXPECT_EQ(std::signbit(look.beam.bearing), std::signbit(bearing));  // to the byte, in a log
    EXPECT_EQ(look.world, look.beam.range > 0.0F);
  }
  EXPECT_DOUBLE_EQ(lidar.beamTime(), 1.0 / (5.5 * 360));
  EXPECT_EQ(lidar.gap(), 0.0);
}

TEST(SituatedLidar, ANarrowViewIsSweptOnceATurn) {
  const World world = room();
  const SituatedLidar lidar(world, with({"field-of-view=90", "beams=100", "turn-rate=10"}), 1);
  EXPECT_NEAR(lidar.bearing(0), kPi / 4, 1e-9);
  EXPECT_NEAR(lidar.bearing(50), 0.0, 1e-9);
  EXPECT_NEAR(100 * lidar.beamTime(), 0.025, 1e-12);
  EXPECT_NEAR(100 * lidar.beamTime() + lidar.gap(), 0.1, 1e-12);
}

TEST(SituatedLidar, WritesTheCodesOfNoReturn) {
  const World nothing;
  SituatedLidar rim(nothing, with({"no-return=8.183,8.187,8.191"}), 1);
  int seen[3] = {};
  for (int i = 0; i < 360; ++i) {
    const float range = rim.look({}, i, false).beam.range;
    seen[range == 8.183F ? 0 : range == 8.187F ? 1 : 2] += 1;
    EXPECT_TRUE(range == 8.183F || range == 8.187F || range == 8.191F) << range;
  }
  for (const int count : seen) EXPECT_GT(count, 80);
  // Whatever the order of the two.
  EXPECT_EQ(SituatedLidar(nothing, with({"no-return=max", "range-max=8"}), 1).look({}, 0, false).beam.range, 8.0F);
  EXPECT_EQ(SituatedLidar(nothing, with({"range-max=8", "no-return=over"}), 1).look({}, 0, false).beam.range, 9.0F);
  EXPECT_EQ(SituatedLidar(nothing, with({"range-max=8", "claimed-range-max=80"}), 1).claimedRangeMax(), 80.0F);
}

TEST(SituatedLidar, SeesItsCasingBeforeTheWorldAndNothingWhenCovered) {
  const World world = room();
  SituatedLidar lidar(world, with({"casing=-10,10,0.25"}), 1);
  int casing = 0;
  for (int i = 0; i < 360; ++i) {
    const auto look = lidar.look({}, i, false);
    if (look.beam.range <= 0.0F) continue;
    if (std::abs(lidar.bearing(i)) < 0.16) {
      EXPECT_NEAR(look.beam.range, 0.25, 0.03);
      EXPECT_FALSE(look.world);
      ++casing;
    } else if (std::abs(lidar.bearing(i)) > 0.19) {
      EXPECT_GT(look.beam.range, 3.0);
      EXPECT_TRUE(look.world);
    }
    EXPECT_EQ(lidar.look({}, i, true).beam.range, 0.0F);
  }
  EXPECT_GT(casing, 15);
}

/// Mean distance from the room's walls at which the merged points of all returns lie.
double misfit(std::initializer_list<const char*> kinds) {
  const World world = room();
  SituatedLidar lidar(world, with(kinds), 3);
  const Pose2 pose{0.4, 0.3, 0.2};
  double sum = 0.0;
  int count = 0;
  for (int i = 0; i < 360; ++i) {
    const Beam beam = lidar.look(pose, i, false).beam;
    if (!(beam.range > 0.0F)) continue;
    const Eigen::Vector2d p = pose * LidarModel::kExtrinsics *
                              Eigen::Vector2d(beam.range * std::cos(beam.bearing), beam.range * std::sin(beam.bearing));
    sum += std::min(std::abs(std::abs(p.x()) - 4.95), std::abs(std::abs(p.y()) - 3.95));
    ++count;
  }
  EXPECT_GT(count, 340);
  return sum / count;
}

TEST(SituatedLidar, TwoMergedOnesAgreeUnlessOneIsTurned) {
  EXPECT_LT(misfit({}), 0.02);
  EXPECT_LT(misfit({"second-lidar=0"}), 0.02);
  EXPECT_GT(misfit({"second-lidar=5"}), 0.05);
}

TEST(SituatedLidar, ErrorsThatEachScanHasAreAsGiven) {
  const World world = room();
  const Pose2 pose{1.0, -0.5, 0.7};
  Situation sound = with({"range-noise=0", "range-noise-per-metre=0"}), wrong = sound;
  sound.lidar.angle_jitter = wrong.lidar.angle_jitter = sound.lidar.dropout = wrong.lidar.dropout = 0.0;
  for (const char* kind : {"range-bias=0.03", "range-scale=0.01", "bearing-scale=0.02", "lidar-turned=4"})
    addTo(wrong, kind);
  SituatedLidar lidar(world, wrong, 3);
  for (int i = 0; i < 360; ++i) {
    const Beam beam = lidar.look(pose, i, false).beam;
    const double truth = lidar.trueRange(pose, 1.02 * lidar.bearing(i) + 4.0 * kPi / 180.0);
    EXPECT_NEAR(beam.range, 1.01 * truth + 0.03, 1e-6);
    EXPECT_EQ(beam.bearing, static_cast<float>(lidar.bearing(i)));
  }
}

TEST(SituatedLidar, NoiseIsAsGiven) {
  const World world = room();
  const auto deviation = [&](std::initializer_list<const char*> kinds) {
    SituatedLidar lidar(world, with(kinds), 3);
    double sum = 0.0;
    int count = 0;
    for (int i = 0; i < 3000; ++i) {
      const float range = lidar.look({-0.06, 0.0, 0.0}, 0, false).beam.range;
      if (range <= 0.0F) continue;
      sum += (range - 4.95) * (range - 4.95);
      ++count;
    }
    return std::sqrt(sum / count);
  };
  EXPECT_NEAR(deviation({}), 0.004 + 0.003 * 4.95, 0.001);
  EXPECT_NEAR(deviation({"range-noise-per-metre=0.02", "range-noise=0"}), 0.099, 0.005);
  EXPECT_NEAR(deviation({"range-noise-per-metre=0", "range-noise=0.3"}), 0.3, 0.015);
}

}  // namespace
}  // namespace slam::sim::situated_lidar_test
