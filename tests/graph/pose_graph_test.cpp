// SPDX-License-Identifier: BSD-3-Clause
#include "graph/pose_graph.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <algorithm>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <limits>
#include <numbers>
#include <optional>
#include <random>
#include <utility>

namespace slam::pose_graph_test {
namespace {

constexpr double kPi = std::numbers::pi;
constexpr double kNoBound = std::numeric_limits<double>::max();

Edge edge(int from, int to, const Pose2& T_from_to, const Eigen::Matrix3d& covariance) {
  return {.from = from, .to = to, .T_from_to = T_from_to, .information = covariance.inverse()};
}

Eigen::Matrix3d diagonal(double position_sigma, double heading_sigma) {
  return Eigen::Vector3d(position_sigma, position_sigma, heading_sigma).cwiseAbs2().asDiagonal();
}

Eigen::Matrix3d randomMatrix(std::mt19937& random) {
  std::uniform_real_distribution<double> unit(-1.0, 1.0);
  return Eigen::Matrix3d::NullaryExpr([&] { return unit(random); });
}

/// Nodes 0 .. steps, each with an edge from its predecessor.
PoseGraph chain(int steps, const Pose2& step, const Eigen::Matrix3d& covariance) {
  PoseGraph graph;
  graph.addNode({});
  for (int i = 0; i < steps; ++i) {
    graph.addNode(graph.pose(i) * step);
    graph.addEdge(edge(i, i + 1, step, covariance));
  }
  return graph;
}

std::vector<int> nodes(const std::vector<PoseGraph::Reached>& reached) {
  std::vector<int> ids;
  for (const auto& node : reached) ids.push_back(node.node);
  return ids;
}

std::optional<PoseGraph::Reached> find(const std::vector<PoseGraph::Reached>& reached, int node) {
  const auto found = std::find_if(reached.begin(), reached.end(), [&](const auto& r) { return r.node == node; });
  return found == reached.end() ? std::nullopt : std::optional(*found);
}

/// Sample variance of a node's position relative to the anchor, the larger of x and y, when each edge errs as it
/// claims.
double sampledVariance(const PoseGraph& graph, int anchor, int node, std::mt19937& random) {
  constexpr int kSamples = 4000;
  std::normal_distribution<double> normal;
  const Pose2 truth = between(graph.pose(anchor), graph.pose(node));
  Eigen::Matrix2d sum = Eigen::Matrix2d::Zero();
  for (int sample = 0; sample < kSamples; ++sample) {
    std::vector<Pose2> poses{{}};
    for (const Edge& e : graph.edges()) {
      const Eigen::Matrix3d root = Eigen::Matrix3d(e.information.inverse()).llt().matrixL();
      const Eigen::Vector3d noise = root * Eigen::Vector3d(normal(random), normal(random), normal(random));
      const Pose2 erred{e.T_from_to.x + noise.x(), e.T_from_to.y + noise.y(), e.T_from_to.theta + noise.z()};
      poses.push_back(poses[static_cast<std::size_t>(e.from)] * erred);
    }
    const Pose2 seen = between(poses[static_cast<std::size_t>(anchor)], poses[static_cast<std::size_t>(node)]);
    const Eigen::Vector2d error = seen.translation() - truth.translation();
    sum += error * error.transpose();
  }
  return sum.selfadjointView<Eigen::Lower>().eigenvalues().maxCoeff() / kSamples;
}

TEST(PoseGraph, CountsIdsFromZero) {
  PoseGraph graph;
  EXPECT_EQ(graph.addNode({}), 0);
  EXPECT_EQ(graph.addNode({1, 2, 3}), 1);
  EXPECT_EQ(graph.addEdge({.from = 0, .to = 1, .T_from_to = {}}), 0);
  EXPECT_EQ(graph.addEdge({.from = 1, .to = 0, .T_from_to = {}}), 1);
  EXPECT_EQ(graph.size(), 2);
  EXPECT_EQ(graph.pose(1), (Pose2{1, 2, 3}));
}

TEST(PoseGraphReach, BoundsTheVarianceOfCurvedChainsSeenFromEitherEnd) {
  std::mt19937 random(1);
  std::uniform_real_distribution<double> turn(-0.6, 0.6), length(0.1, 1.5);
  for (int trial = 0; trial < 20; ++trial) {
    PoseGraph graph;
    graph.addNode({});
    for (int i = 0; i < 12; ++i) {
      const Pose2 step{length(random), 0.2 * turn(random), turn(random)};
      Eigen::Matrix3d A = randomMatrix(random);  // errors of x and y depend on each other, that of the heading does not
      A.topRows<2>() *= 0.01;
      A.topRightCorner<2, 1>().setZero();
      A.row(2) = Eigen::RowVector3d(0.0, 0.0, 0.02);
      graph.addNode(graph.pose(i) * step);
      graph.addEdge(edge(i, i + 1, step, A * A.transpose() + diagonal(0.003, 0.003)));
    }
    for (const auto& [anchor, node] : {std::pair(0, 12), std::pair(12, 0), std::pair(5, 9), std::pair(9, 5)}) {
      const auto reached = find(graph.reach(anchor, kNoBound), node);
      ASSERT_TRUE(reached);
      ASSERT_LT(sampledVariance(graph, anchor, node, random), 1.1 * reached->position_variance)
          << "trial " << trial << ", " << anchor << " to " << node;
    }
  }
}

TEST(PoseGraphReach, IsTightOnAStraightChain) {
  std::mt19937 random(1);
  const PoseGraph graph = chain(20, {0.5, 0.0, 0.0}, diagonal(0.01, 0.005));
  for (const auto& [anchor, node] : {std::pair(0, 20), std::pair(20, 0)}) {
    const auto reached = find(graph.reach(anchor, kNoBound), node);
    ASSERT_TRUE(reached);
    const double sampled = sampledVariance(graph, anchor, node, random);
    EXPECT_NEAR(reached->position_variance, sampled, 0.1 * sampled) << anchor;
    EXPECT_NEAR(reached->heading_variance, 20 * 0.005 * 0.005, 1e-6) << anchor;
  }
}

TEST(PoseGraphReach, BeginsWithTheAnchorAndGoesOnFromTheBestKnown) {
  const PoseGraph graph = chain(6, {0.4, 0.0, 0.1}, diagonal(0.01, 0.001));
  const auto reached = graph.reach(2, kNoBound);
  ASSERT_EQ(reached.size(), 7U);
  EXPECT_EQ(reached[0].node, 2);
  EXPECT_EQ(reached[0].position_variance, 0.0);
  EXPECT_EQ(reached[0].heading_variance, 0.0);
  for (std::size_t i = 1; i < reached.size(); ++i)
    EXPECT_GE(reached[i].position_variance, reached[i - 1].position_variance);
}

TEST(PoseGraphReach, EndsAtTheBound) {
  const PoseGraph graph = chain(10, {0.0, 0.0, 0.0}, diagonal(0.1, 0.001));  // 0.01 m^2 a step
  EXPECT_THAT(nodes(graph.reach(5, 0.025)), testing::UnorderedElementsAre(3, 4, 5, 6, 7));
  EXPECT_THAT(nodes(graph.reach(5, 0.0)), testing::ElementsAre(5));
}

TEST(PoseGraphReach, StopsBehindTheLastThatIsWanted) {
  const PoseGraph graph = chain(10, {0.4, 0.0, 0.1}, diagonal(0.01, 0.001));
  const std::vector<int> all = nodes(graph.reach(5, kNoBound));
  for (const std::vector<int>& wanted : {std::vector{3, 6}, {5}, {0}, {}}) {
    std::size_t last = wanted.empty() ? all.size() : 0;
    for (const int node : wanted) {
      const auto at = std::find(all.begin(), all.end(), node);
      last = std::max(last, static_cast<std::size_t>(at - all.begin()) + 1);
    }
    const std::vector<int> expected(all.begin(), all.begin() + static_cast<std::ptrdiff_t>(last));
    EXPECT_EQ(nodes(graph.reach(5, kNoBound, wanted)), expected);
    EXPECT_EQ(nodes(graph.reach(5, kNoBound)), all) << "and leaves nothing behind";
  }
}

TEST(PoseGraphReach, HasNoMemoryOfOtherBoundsAndAnchors) {
  const auto make = [] { return chain(10, {0.4, 0.0, 0.1}, diagonal(0.01, 0.001)); };
  const PoseGraph graph = make();
  for (const auto& [anchor, bound] :
       {std::pair(5, 1.5e-4), std::pair(5, 3.5e-4), std::pair(5, 2.5e-4), std::pair(2, 3.5e-4)}) {
    const auto expected = make().reach(anchor, bound), reached = graph.reach(anchor, bound);
    ASSERT_EQ(nodes(reached), nodes(expected)) << anchor << " " << bound;
    EXPECT_GT(reached.size(), 1U);
    EXPECT_LT(reached.size(), 11U) << "what lies behind the bound was found before, or not yet";
    EXPECT_EQ(reached.back().position_variance, expected.back().position_variance);
  }
}

TEST(PoseGraphReach, TakesTheBestOfSeveralChains) {
  PoseGraph graph = chain(10, {0.4, 0.0, 0.0}, diagonal(0.02, 0.001));
  const double around = find(graph.reach(0, kNoBound), 10)->position_variance;
  graph.addEdge(edge(0, 10, {4.0, 0.0, 0.0}, diagonal(0.5, 0.001)));
  EXPECT_DOUBLE_EQ(find(graph.reach(0, kNoBound), 10)->position_variance, around) << "the worse chain counts";
  graph.addEdge(edge(10, 0, {-4.0, 0.0, 0.0}, diagonal(0.01, 1e-6)));
  EXPECT_NEAR(find(graph.reach(0, kNoBound), 10)->position_variance, 1e-4, 1e-6);
  EXPECT_LT(find(graph.reach(0, kNoBound), 9)->position_variance, 6e-4) << "from the other end";
}

TEST(PoseGraphReach, RevokedEdgesCountForNothingUntilRestored) {
  PoseGraph graph = chain(4, {0.4, 0.0, 0.0}, diagonal(0.01, 0.001));
  graph.revoke(2);
  EXPECT_THAT(nodes(graph.reach(0, kNoBound)), testing::ElementsAre(0, 1, 2));
  graph.restore(2);
  EXPECT_THAT(nodes(graph.reach(0, kNoBound)), testing::ElementsAre(0, 1, 2, 3, 4));
}

TEST(PoseGraphReach, DoesNotReachWhatNothingJoins) {
  PoseGraph graph = chain(3, {0.4, 0.0, 0.0}, diagonal(0.01, 0.001));
  graph.addNode({0.4, 0.0, 0.0});  // there, but joined to nothing
  EXPECT_EQ(nodes(graph.reach(0, kNoBound)).size(), 4U);
  EXPECT_THAT(nodes(graph.reach(4, kNoBound)), testing::ElementsAre(4));
}

TEST(PoseGraphReach, HasNoInformationAlongABlindDirection) {
  for (const double angle : {0.0, kPi / 4, kPi / 2, 2.0}) {
    const Eigen::Vector3d seen(-std::sin(angle), std::cos(angle), 0.0);  // a corridor along `angle`
    PoseGraph graph;
    graph.addNode({});
    graph.addNode({});
    graph.addEdge(
        {.from = 0,
         .to = 1,
         .T_from_to = {},
         .information = 1e4 * (seen * seen.transpose()) + Eigen::Matrix3d(Eigen::Vector3d(0, 0, 1e6).asDiagonal())});
    EXPECT_THAT(nodes(graph.reach(0, 25.0)), testing::ElementsAre(0)) << angle;
    EXPECT_GT(find(graph.reach(0, kNoBound), 1)->position_variance, 90.0) << angle;
  }
}

TEST(PoseGraphReach, AnswersTheSameTwice) {
  const PoseGraph graph = chain(8, {0.4, 0.1, 0.2}, diagonal(0.01, 0.002));
  const auto first = graph.reach(0, 4e-4);
  graph.reach(8, kNoBound);
  EXPECT_EQ(nodes(graph.reach(0, 4e-4)), nodes(first));
  EXPECT_EQ(graph.reach(0, kNoBound).size(), 9U);
}

class ChiSquare : public testing::Test {
 protected:
  ChiSquare() {
    const Eigen::Matrix3d A = randomMatrix(random);
    measured.information = A * A.transpose() + Eigen::Matrix3d::Identity();
  }
  Pose2 draw(double size = 5.0) {
    std::uniform_real_distribution<double> unit(-1.0, 1.0);
    const double x = size * unit(random), y = size * unit(random);
    return {x, y, kPi * unit(random)};
  }
  std::mt19937 random{1};
  Edge measured{.from = 0, .to = 1, .T_from_to = {0.5, -0.2, 2.5}};
};

TEST_F(ChiSquare, IsTheSquaredMahalanobisDistanceInTheMeasuredFrame) {
  for (int trial = 0; trial < 100; ++trial) {
    const Pose2 from = draw();
    const Pose2 error{0.01 * trial, -0.02, 0.003 * trial};
    const Eigen::Vector3d e = error.vector();
    EXPECT_NEAR(chiSquare(measured, from, from * measured.T_from_to * error), e.dot(measured.information * e), 1e-9);
  }
}

TEST_F(ChiSquare, DoesNotDependOnWhereTheMapLies) {
  for (int trial = 0; trial < 100; ++trial) {
    const Pose2 from = draw(), to = draw(), moved = draw(50.0);
    const double expected = chiSquare(measured, from, to);
    EXPECT_NEAR(chiSquare(measured, moved * from, moved * to), expected, 1e-9 * (1.0 + expected));
  }
}

TEST_F(ChiSquare, IsZeroAtTheMeasurementAndPositiveElsewhere) {
  for (int trial = 0; trial < 100; ++trial) {
    const Pose2 from = draw();
    EXPECT_NEAR(chiSquare(measured, from, from * measured.T_from_to), 0.0, 1e-12);
    EXPECT_GT(chiSquare(measured, from, draw()), 0.0);
  }
}

TEST_F(ChiSquare, TakesTheShortWayRound) {
  measured.T_from_to = {0.0, 0.0, kPi - 0.01};
  measured.information.setIdentity();
  EXPECT_NEAR(chiSquare(measured, {}, {0.0, 0.0, -kPi + 0.01}), 0.02 * 0.02, 1e-9);
}

TEST_F(ChiSquare, CountsNothingAlongABlindDirection) {
  measured.T_from_to = {};
  measured.information = Eigen::Vector3d(0.0, 1e4, 1e4).asDiagonal();
  EXPECT_EQ(chiSquare(measured, {}, {3.0, 0.0, 0.0}), 0.0);
  EXPECT_NEAR(chiSquare(measured, {}, {3.0, 0.02, 0.0}), 4.0, 1e-9);
}

}  // namespace
}  // namespace slam::pose_graph_test
