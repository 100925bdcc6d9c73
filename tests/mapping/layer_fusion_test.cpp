// SPDX-License-Identifier: BSD-3-Clause
#include "mapping/layer_fusion.hpp"

#include <cmath>
#include <gtest/gtest.h>
#include <initializer_list>

namespace slam::layer_fusion_test {
namespace {

const LogOdds kOccupied = toLogOdds(0.9), kEmpty = toLogOdds(0.1), kUncertain = 0;

TEST(LayerFusion, Equation18IsBayesWithAnEvenPrior) {
  EXPECT_NEAR(updated(0.7, 0.6), 0.42 / (0.42 + 0.3 * 0.4), 1e-12);
  EXPECT_NEAR(updated(0.7, 0.5), 0.7, 1e-12) << "nothing was known before";
  EXPECT_NEAR(updated(0.5, 0.2), 0.2, 1e-12) << "the look says nothing";
  EXPECT_EQ(updated(0.3, 1.0), 1.0) << "what is certain stays";
}

TEST(LayerFusion, Equation19MakesTheLikelyCertainAndLeavesTheRest) {
  for (const double p : {0.501, 0.7, 0.999, 1.0}) EXPECT_EQ(certainIfLikely(p), 1.0) << p;
  for (const double p : {0.0, 0.05, 0.3, 0.5}) EXPECT_EQ(certainIfLikely(p), p) << p;
}

TEST(LayerFusion, Equation20CombinesTheLayersAfterEquation19) {
  EXPECT_NEAR(fusedAsInPaper(0.3, 0.4), 0.12 / (0.12 + 0.42), 1e-12);
  EXPECT_EQ(fusedAsInPaper(0.6, 0.05), 1.0);
  EXPECT_EQ(fusedAsInPaper(0.05, 0.6), 1.0);
  EXPECT_NEAR(fusedAsInPaper(0.5, 0.2), 0.2, 1e-12);
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
