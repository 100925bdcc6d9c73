// SPDX-License-Identifier: BSD-3-Clause
#include "depth/visible_ranges.hpp"

#include <gtest/gtest.h>
#include <vector>

namespace slam::visible_ranges_test {
namespace {

constexpr HeightWindow kWindow{.down = 0.35, .up = 0.40, .lift = 0.0, .range_min = 0.5};

/// Bands of a camera that sees from 0.4 below the horizon to 0.4 above it; all have depth but the one that is blind.
struct Column {
  std::vector<DepthRays::Band> bands;
  std::vector<int> valid;
  explicit Column(int blind = -1) {
    for (int i = 0; i < DepthRays::kBands; ++i) {
      const float high = 0.4F - 0.8F * static_cast<float>(i) / DepthRays::kBands;
      bands.push_back({high - 0.8F / DepthRays::kBands, high, 10});
      valid.push_back(i == blind ? 4 : 10);
    }
  }
  VisibleRanges sight(const HeightWindow& window = kWindow) const { return {bands, valid, window}; }
};

TEST(VisibleRanges, SeesAllHeightsFromWhereFloorAndTopComeIntoView) {
  const auto free = Column().sight().freeInterval(4.0);
  EXPECT_NEAR(free.from, 0.40 / 0.4, 1e-6);
  EXPECT_DOUBLE_EQ(free.to, 4.0);
  EXPECT_NEAR(Column().sight().freeBefore(3.0), 1.0, 1e-6);
  EXPECT_NEAR(Column().sight().freeBefore(0.8), 0.8, 1e-6) << "never beyond the obstacle";
}

TEST(VisibleRanges, ABlindBandNearTheHorizonHidesWhatLiesFar) {
  const auto free = Column(12).sight().freeInterval(8.0);  // looks up by 0.075 to 0.1
  EXPECT_NEAR(free.from, 0.40 / 0.075, 1e-3) << "behind it the band looks above the robot's top";
  EXPECT_DOUBLE_EQ(free.to, 8.0);
  EXPECT_LT(Column(12).sight().freeInterval(4.0).to, Column(12).sight().freeInterval(4.0).from) << "nothing is free";
}

TEST(VisibleRanges, ABlindBandThatLooksOverANearPlaceHidesOnlyFartherOnes) {
  const HeightWindow high{.down = 1.0, .up = -0.2, .lift = 0.0, .range_min = 0.5};  // the camera above the robot's top
  const auto free = Column(17).sight(high).freeInterval(8.0);                       // looks down by 0.025 to 0.05
  EXPECT_NEAR(free.from, 1.0 / 0.4, 1e-3);
  EXPECT_NEAR(free.to, 0.2 / 0.05, 1e-3);
}

TEST(VisibleRanges, ATiltOfTheFloorMovesWhatIsSeen) {
  HeightWindow uphill = kWindow;
  uphill.lift = 0.1;
  EXPECT_NEAR(Column().sight(uphill).freeInterval(4.0).from, 0.40 / 0.3, 1e-6);
}

TEST(VisibleRanges, ABandWithoutPixelsIsNotBlind) {
  Column column;
  column.bands[12].pixels = 0;
  column.valid[12] = 0;
  EXPECT_NEAR(column.sight().freeInterval(4.0).from, 1.0, 1e-6);
}

}  // namespace
}  // namespace slam::visible_ranges_test
