// SPDX-License-Identifier: BSD-3-Clause
#include "core/scan.hpp"

#include <cmath>
#include <gtest/gtest.h>
#include <limits>
#include <memory>
#include <numbers>
#include <type_traits>

namespace slam::scan_test {
namespace {

static_assert(std::is_trivially_copyable_v<Beam> && std::is_nothrow_destructible_v<LaserScan>);

TEST(LaserScan, IsCopiedWithTheBeamsThatItHas) {
  const auto scan = std::make_unique<LaserScan>();
  scan->stamp = Timestamp(std::chrono::seconds(7));
  scan->range_min = 0.25F;
  scan->range_max = 9.0F;
  for (int i = 0; i < 3; ++i) scan->push({.range = 1.0F + static_cast<float>(i), .bearing = 0.5F});
  const auto copy = std::make_unique<LaserScan>(*scan), assigned = std::make_unique<LaserScan>();
  assigned->push({.range = 8.0F});
  *assigned = *scan;
  for (const LaserScan* other : {copy.get(), assigned.get()}) {
    EXPECT_EQ(other->stamp, scan->stamp);
    EXPECT_EQ(other->range_min, 0.25F);
    EXPECT_EQ(other->range_max, 9.0F);
    ASSERT_EQ(other->size, 3);
    for (std::size_t i = 0; i < 3; ++i) EXPECT_EQ(other->beams()[i].range, scan->beams()[i].range);
  }
}

TEST(LaserScan, TakesBeamsInOrderUntilItIsFull) {
  const auto scan = std::make_unique<LaserScan>();
  EXPECT_TRUE(scan->beams().empty());
  for (int i = 0; i < LaserScan::kCapacity; ++i) ASSERT_TRUE(scan->push({.range = 1.0F + static_cast<float>(i)}));

  EXPECT_FALSE(scan->push({.range = -1.0F}));

  ASSERT_EQ(scan->beams().size(), static_cast<std::size_t>(LaserScan::kCapacity));
  for (int i = 0; i < LaserScan::kCapacity; ++i)
    ASSERT_EQ(scan->beams()[static_cast<std::size_t>(i)].range, 1.0F + static_cast<float>(i));
}

TEST(LaserScan, CountsRangesWithinItsLimitsAsReturns) {
  const auto scan = std::make_unique<LaserScan>();
  scan->range_min = 0.5F;
  scan->range_max = 8.0F;
  const auto isReturn = [&](float range) { return scan->isReturn({.range = range}); };
  EXPECT_TRUE(isReturn(0.5F));
  EXPECT_TRUE(isReturn(8.0F));
  EXPECT_FALSE(isReturn(0.49F));
  EXPECT_FALSE(isReturn(8.01F));
  EXPECT_FALSE(isReturn(0.0F));
  EXPECT_FALSE(isReturn(-1.0F));
  EXPECT_FALSE(isReturn(std::numeric_limits<float>::quiet_NaN()));
  EXPECT_FALSE(isReturn(std::numeric_limits<float>::infinity()));
}

constexpr double kDegree = std::numbers::pi / 180.0;

/// A casing of so many degrees from one of them on, at a range.
BodyShape casing(int first, int degrees, std::uint16_t millimetres) {
  BodyShape shape;
  for (int i = 0; i < degrees; ++i) shape.millimetres[static_cast<std::size_t>((first + i) % 360)] = millimetres;
  return shape;
}
Eigen::Vector2d at(double range, double degrees) {
  return range * Eigen::Vector2d(std::cos(degrees * kDegree), std::sin(degrees * kDegree));
}

TEST(BodyShape, GivesHowMuchOfTheTurnItTakesAndWhere) {
  EXPECT_EQ(BodyShape().degrees(), 0);
  EXPECT_EQ(casing(350, 20, 300).degrees(), 20);
  EXPECT_NEAR(casing(350, 20, 300).middle(), 0.0, 1e-9);
  EXPECT_NEAR(casing(80, 20, 300).middle(), 90.0, 1e-9);
  EXPECT_NEAR(std::abs(casing(170, 20, 300).middle()), 180.0, 1e-9);
}

TEST(BodyShape, HoldsPointsOnItAndThoseBesideItWithinTheMargin) {
  const BodyShape shape = casing(80, 20, 300);
  EXPECT_TRUE(shape.holds(at(0.30, 90.0), 0.01));
  EXPECT_TRUE(shape.holds(at(0.34, 95.2), 0.05));
  EXPECT_FALSE(shape.holds(at(0.36, 95.2), 0.05));
  EXPECT_TRUE(shape.holds(at(0.30, 105.0), 0.05)) << "3 cm beside it";
  EXPECT_FALSE(shape.holds(at(0.30, 115.0), 0.05)) << "8 cm beside it";
  EXPECT_FALSE(shape.holds(at(0.30, -90.0), 0.05));
  EXPECT_FALSE(BodyShape().holds({0.0, 0.0}, 0.05)) << "a range of 0 is none";
}

TEST(BodyShape, OfALidarUpsideDownIsMirrored) {
  const BodyShape shape = casing(40, 10, 300), mirrored = shape.mirrored();
  EXPECT_NEAR(mirrored.middle(), -shape.middle(), 1e-9);
  EXPECT_TRUE(mirrored.holds(at(0.30, -45.0), 0.001 + 0.3 * kDegree));
  EXPECT_EQ(mirrored.mirrored(), shape);
}

TEST(BodyShape, GivesWhatIsNewInIt) {
  EXPECT_EQ(casing(40, 10, 300).without(casing(45, 20, 500)), casing(40, 5, 300));
  EXPECT_EQ(casing(40, 10, 300).without(casing(40, 10, 310)).degrees(), 0);
  EXPECT_EQ(casing(40, 10, 300).without({}), casing(40, 10, 300));
}

}  // namespace
}  // namespace slam::scan_test
