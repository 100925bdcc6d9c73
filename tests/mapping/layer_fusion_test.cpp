// SPDX-License-Identifier: BSD-3-Clause
#include "mapping/layer_fusion.hpp"

#include <cmath>
#include <gtest/gtest.h>
#include <initializer_list>

namespace slam::layer_fusion_test {
namespace {

const LogOdds kOccupied = toLogOdds(0.9), kEmpty = toLogOdds(0.1), kUncertain = 0;

/// The paper's eq. 20, by 18, on layers that eq. 19 was applied to; it obeys Table II as long as no layer is as low as
/// 0.
double fusedAsInPaper(double lidar, double depth) {
  const auto certainIfLikely = [](double probability) { return probability > 0.5 ? 1.0 : probability; };  // eq. 19
  const double sensor = certainIfLikely(lidar), map = certainIfLikely(depth);
  const double occupied = sensor * map, empty = (1.0 - sensor) * (1.0 - map);
  return occupied / (occupied + empty);
}

/// One cell of the paper's Table II.
struct Rule {
  const char* name;
  LogOdds lidar, depth;
  int result;  // 1 occupied, -1 empty, 0 uncertain
};
class TableTwo : public testing::TestWithParam<Rule> {};

TEST_P(TableTwo, HoldsForBothFusions) {
  const Rule& rule = GetParam();
  for (const Fusion fusion : {Fusion::kPaper, Fusion::kLayers}) {
    const LogOdds value = fused(fusion, rule.lidar, rule.depth);
    EXPECT_EQ((value > 0) - (value < 0), rule.result) << static_cast<int>(fusion);
  }
}

INSTANTIATE_TEST_SUITE_P(
    LayerFusion, TableTwo,
    testing::Values(Rule{"OccupiedOccupied", kOccupied, kOccupied, 1}, Rule{"OccupiedEmpty", kOccupied, kEmpty, 1},
                    Rule{"OccupiedUncertain", kOccupied, kUncertain, 1}, Rule{"EmptyOccupied", kEmpty, kOccupied, 1},
                    Rule{"EmptyEmpty", kEmpty, kEmpty, -1}, Rule{"EmptyUncertain", kEmpty, kUncertain, -1},
                    Rule{"UncertainOccupied", kUncertain, kOccupied, 1}, Rule{"UncertainEmpty", kUncertain, kEmpty, -1},
                    Rule{"UncertainUncertain", kUncertain, kUncertain, 0}),
    [](const auto& rule) { return rule.param.name; });

TEST(LayerFusion, InLogOddsThePapersFusionIsEquations19And20) {
  for (LogOdds lidar = -3000; lidar <= 3500; lidar = static_cast<LogOdds>(lidar + 125)) {
    for (LogOdds depth = -3000; depth <= 3500; depth = static_cast<LogOdds>(depth + 125)) {
      const double expected = fusedAsInPaper(toProbability(lidar), toProbability(depth));
      ASSERT_NEAR(toProbability(fused(Fusion::kPaper, lidar, depth)), expected, 1e-9) << lidar << " " << depth;
    }
  }
}

TEST(LayerFusion, MoreEvidenceOfAnObstacleInALayerNeverMakesTheCellFreer) {
  for (const LogOdds depth : {LogOdds{-2000}, LogOdds{-1}, LogOdds{1}, LogOdds{2000}}) {
    LogOdds last = fusedLayers(-3000, depth);
    for (LogOdds lidar = -2999; lidar <= 3500; ++lidar) {
      const LogOdds now = fusedLayers(lidar, depth);
      ASSERT_GE(now, last) << lidar << " " << depth;
      last = now;
    }
  }
}

TEST(LayerFusion, CertaintySurvivesTheWayToProbabilityAndBack) {
  EXPECT_EQ(toProbability(kCertain), 1.0);
  EXPECT_LT(toProbability(toLogOdds(0.999)), 1.0);
}

}  // namespace
}  // namespace slam::layer_fusion_test
