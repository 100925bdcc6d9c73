// SPDX-License-Identifier: BSD-3-Clause
#include "core/scan.hpp"

#include <gtest/gtest.h>
#include <limits>
#include <memory>
#include <type_traits>

namespace slam {
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

}  // namespace
}  // namespace slam
