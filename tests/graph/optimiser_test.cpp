// SPDX-License-Identifier: BSD-3-Clause
#include "graph/optimiser.hpp"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <array>
#include <ceres/ceres.h>
#include <gtest/gtest.h>
#include <limits>
#include <numbers>
#include <numeric>
#include <random>

#include "support/simulated/campus.hpp"

namespace slam::optimiser_test {
namespace {

using test::Campus;
using test::makeCampus;
using test::measuredEdge;

constexpr double kPi = std::numbers::pi;
const OptimiserConfig kThorough{.max_iterations = 200, .relative_tolerance = 1e-14, .step_tolerance = 1e-9};

double distance(const Pose2& a, const Pose2& b) { return std::hypot(a.x - b.x, a.y - b.y); }

/// Largest difference of two sets of poses, a radian counted as a metre.
double difference(std::span<const Pose2> a, std::span<const Pose2> b) {
  double largest = 0.0;
  for (std::size_t i = 0; i < a.size(); ++i)
    largest = std::max({largest, distance(a[i], b[i]), std::abs(wrapAngle(a[i].theta - b[i].theta))});
  return largest;
}

double meanError(const PoseGraph& graph, const std::vector<Pose2>& truth) {
  double sum = 0.0;
  for (int i = 0; i < graph.size(); ++i) sum += distance(graph.pose(i), truth[static_cast<std::size_t>(i)]);
  return sum / graph.size();
}

std::vector<Pose2> posesOf(const PoseGraph& graph) { return {graph.poses().begin(), graph.poses().end()}; }

/// e = T_from_to^-1 * (T_from^-1 * T_to), weighted, for automatic differentiation.
struct EdgeError {
  Edge edge;
  Eigen::Matrix3d root;  // root^T root = information

  template <typename T>
  bool operator()(const T* from, const T* to, T* error) const {
    using std::cos, std::sin;
    const T dx = to[0] - from[0], dy = to[1] - from[1];
    const T x = cos(from[2]) * dx + sin(from[2]) * dy - edge.T_from_to.x;
    const T y = -sin(from[2]) * dx + cos(from[2]) * dy - edge.T_from_to.y;
    const double c = std::cos(edge.T_from_to.theta), s = std::sin(edge.T_from_to.theta);
    const T angle = to[2] - from[2] - edge.T_from_to.theta;
    const std::array<T, 3> e{c * x + s * y, -s * x + c * y,
                             angle - 2.0 * kPi * ceres::floor((angle + kPi) / (2 * kPi))};
    for (int i = 0; i < 3; ++i) error[i] = root(i, 0) * e[0] + root(i, 1) * e[1] + root(i, 2) * e[2];
    return true;
  }
};

struct Solution {
  std::vector<Pose2> poses;
  double cost;
};

/// The same problem solved by Ceres from the graph's present poses.
Solution solvedByCeres(const PoseGraph& graph, double kernel_scale) {
  std::vector<std::array<double, 3>> values;
  for (const Pose2& pose : graph.poses()) values.push_back({pose.x, pose.y, pose.theta});
  ceres::Problem problem;
  for (const Edge& edge : graph.edges()) {
    if (edge.revoked) continue;
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> eigen(edge.information);
    const Eigen::Matrix3d root =
        eigen.eigenvalues().cwiseMax(0.0).cwiseSqrt().asDiagonal() * eigen.eigenvectors().transpose();
    problem.AddResidualBlock(new ceres::AutoDiffCostFunction<EdgeError, 3, 3, 3>(new EdgeError{edge, root}),
                             edge.kind == EdgeKind::kMotion ? nullptr : new ceres::CauchyLoss(kernel_scale),
                             values[static_cast<std::size_t>(edge.from)].data(),
                             values[static_cast<std::size_t>(edge.to)].data());
  }
  problem.SetParameterBlockConstant(values[0].data());
  ceres::Solver::Options options;
  options.linear_solver_type = ceres::SPARSE_NORMAL_CHOLESKY;
  options.max_num_iterations = 500;
  options.function_tolerance = options.gradient_tolerance = options.parameter_tolerance = 1e-14;
  options.logging_type = ceres::SILENT;
  ceres::Solver::Summary summary;
  ceres::Solve(options, &problem, &summary);
  Solution solution{.poses = {}, .cost = summary.final_cost};
  for (const auto& value : values) solution.poses.push_back({value[0], value[1], wrapAngle(value[2])});
  return solution;
}

Eigen::Matrix3d randomInformation(std::mt19937& random) {
  std::uniform_real_distribution<double> unit(-1.0, 1.0);
  const Eigen::Matrix3d A = Eigen::Matrix3d::NullaryExpr([&] { return unit(random); });
  return 100.0 * (A * A.transpose() + 0.2 * Eigen::Matrix3d::Identity());
}

/// Nodes on a wild path and edges between any two of them, in either direction; first poses far from the best ones.
PoseGraph tangle(int size, std::mt19937& random) {
  std::normal_distribution<double> normal;
  std::uniform_int_distribution<int> any(0, size - 1);
  std::vector<Pose2> truth{{1.0, 2.0, 0.5}};
  PoseGraph graph;
  graph.addNode(truth[0]);
  const auto add = [&](int from, int to, EdgeKind kind) {
    Edge edge = measuredEdge(truth, from, to, {0.05, 0.05, 0.02}, kind, random);
    edge.information = randomInformation(random);
    graph.addEdge(edge);
  };
  for (int i = 1; i < size; ++i) {
    truth.push_back(truth.back() * Pose2{0.5 + 0.2 * normal(random), 0.1 * normal(random), 0.4 * normal(random)});
    graph.addNode(truth.back() * Pose2{0.1 * normal(random), 0.1 * normal(random), 0.05 * normal(random)});
    if (i % 3 == 0) {
      add(i, i - 1, EdgeKind::kMotion);
    } else {
      add(i - 1, i, EdgeKind::kMotion);
    }
  }
  for (int i = 0; i < size / 2; ++i) {
    const int from = any(random), to = any(random);
    if (from != to) add(from, to, EdgeKind::kLoopClosure);
  }
  return graph;
}

/// A closed square of keyframes 0.5 m apart, walked twice, with a closure wherever the second round passes the first.
struct Square {
  PoseGraph graph;
  std::vector<Pose2> truth{{}};

  explicit Square(unsigned seed, double noise = 1.0) {
    std::mt19937 random(seed);
    constexpr int kSide = 10, kRound = 4 * kSide;
    const Eigen::Vector3d step(0.01, 0.01, 0.005), closure(0.02, 0.02, 0.005);
    graph.addNode({});
    for (int i = 1; i <= 2 * kRound; ++i) {
      truth.push_back(truth.back() * Pose2{0.5, 0.0, i % kSide == 0 ? kPi / 2 : 0.0});
      Edge edge = measuredEdge(truth, i - 1, i, noise * step, EdgeKind::kMotion, random);
      edge.information = step.cwiseAbs2().cwiseInverse().asDiagonal();
      graph.addNode(graph.pose(i - 1) * edge.T_from_to);
      graph.addEdge(edge);
    }
    for (int i = kRound; i <= 2 * kRound; i += 5) {
      Edge edge = measuredEdge(truth, i - kRound, i, noise * closure, EdgeKind::kLoopClosure, random);
      edge.information = closure.cwiseAbs2().cwiseInverse().asDiagonal();
      graph.addEdge(edge);
    }
  }
};

TEST(Optimiser, AgreesWithCeresOnACampus) {
  for (const unsigned seed : {1U, 2U, 3U}) {
    Campus campus = makeCampus(1500, seed);
    ASSERT_GT(campus.closures.size(), 5U);
    for (const Edge& closure : campus.closures) campus.graph.addEdge(closure);
    const Solution expected = solvedByCeres(campus.graph, kThorough.kernel_scale);
    Optimiser optimiser(kThorough);
    const OptimiserReport report = optimiser.optimise(campus.graph);
    EXPECT_TRUE(report.converged) << seed;
    EXPECT_LT(difference(campus.graph.poses(), expected.poses), 1e-4) << seed;
    EXPECT_NEAR(report.cost_after, expected.cost, 1e-6 * expected.cost) << seed;
  }
}

TEST(Optimiser, AgreesWithCeresOnTanglesOfEdgesEitherWay) {
  std::mt19937 random(1);
  for (int trial = 0; trial < 30; ++trial) {
    PoseGraph graph = tangle(40, random);
    const Solution expected = solvedByCeres(graph, kThorough.kernel_scale);
    Optimiser optimiser(kThorough);
    const OptimiserReport report = optimiser.optimise(graph);
    ASSERT_TRUE(report.converged) << trial;
    ASSERT_LT(difference(graph.poses(), expected.poses), 1e-4) << trial;
    ASSERT_NEAR(report.cost_after, expected.cost, 1e-6 * expected.cost) << trial;
  }
}

TEST(Optimiser, AgreesWithCeresWhereAClosureIsWrong) {
  Square square(1);
  Edge wrong{.from = 3, .to = 55, .T_from_to = {2.0, 1.0, 1.0}, .kind = EdgeKind::kLoopClosure};
  wrong.information = Eigen::Vector3d(2500.0, 2500.0, 4e4).asDiagonal();
  square.graph.addEdge(wrong);
  const Solution expected = solvedByCeres(square.graph, kThorough.kernel_scale);
  Optimiser optimiser(kThorough);
  optimiser.optimise(square.graph);
  EXPECT_LT(difference(square.graph.poses(), expected.poses), 1e-4);
}

TEST(Optimiser, ComesNearTheOptimumWithItsDefaultTolerances) {
  Campus campus = makeCampus(1500, 4);
  for (const Edge& closure : campus.closures) campus.graph.addEdge(closure);
  PoseGraph thorough = campus.graph;
  Optimiser optimiser, patient(kThorough);
  const OptimiserReport report = optimiser.optimise(campus.graph);
  patient.optimise(thorough);
  EXPECT_TRUE(report.converged);
  EXPECT_LT(report.cost_after, report.cost_before);
  EXPECT_LT(difference(campus.graph.poses(), thorough.poses()), 0.005);
}

TEST(Optimiser, ClosuresTakeTheDriftAway) {
  for (const unsigned seed : {1U, 2U, 3U, 4U, 5U}) {
    Square square(seed);
    const double before = meanError(square.graph, square.truth);
    Optimiser().optimise(square.graph);
    EXPECT_LT(meanError(square.graph, square.truth), 0.7 * before) << seed;
    EXPECT_EQ(square.graph.pose(0), Pose2{}) << seed;
  }
}

TEST(Optimiser, FindsTheTruthWhereMeasurementsAreExact) {
  Square square(1, 0.0);
  std::mt19937 random(1);
  std::normal_distribution<double> normal;
  for (int i = 1; i < square.graph.size(); ++i) {
    const Pose2 displaced{0.2 * normal(random), 0.2 * normal(random), 0.1 * normal(random)};
    square.graph.setPose(i, square.graph.pose(i) * displaced);
  }
  const OptimiserReport report = Optimiser(kThorough).optimise(square.graph);
  EXPECT_TRUE(report.converged);
  EXPECT_LT(difference(square.graph.poses(), square.truth), 1e-6);
}

TEST(Optimiser, LeavesAnOptimumWhereItIs) {
  for (const double noise : {1.0, 0.0}) {
    Square square(1, noise);
    Optimiser optimiser(kThorough);
    optimiser.optimise(square.graph);
    const auto before = posesOf(square.graph);
    const OptimiserReport again = optimiser.optimise(square.graph);
    EXPECT_TRUE(again.converged) << noise;
    EXPECT_LT(difference(square.graph.poses(), before), 1e-6) << noise;
  }
}

/// A campus whose closures are worked in one after the other, each where it lies.
struct GrowingCampus {
  explicit GrowingCampus(unsigned seed) : campus(makeCampus(4000, seed)) {
    campus.graph.truncate(1500);
    for (; next < campus.closures.size() && campus.closures[next].to < 1500; ++next)
      campus.graph.addEdge(campus.closures[next]);
    Optimiser(kThorough).optimise(campus.graph);
  }
  /// Adds the nodes and motions up to the next closure, and that. @return its ends
  std::array<int, 2> close(const PoseGraph& all) {
    const Edge closure = campus.closures[next++];
    while (campus.graph.size() <= closure.to) {
      const Edge& motion = all.edges()[static_cast<std::size_t>(campus.graph.size()) - 1];
      campus.graph.addNode(campus.graph.pose(motion.from) * motion.T_from_to);
      campus.graph.addEdge(motion);
    }
    campus.graph.addEdge(closure);
    return {closure.from, closure.to};
  }

  Campus campus;
  std::size_t next = 0;
};

TEST(Optimiser, SolvesForWhatAClosureMovesAndForAllFromTimeToTime) {
  constexpr OptimiserConfig kLocal{.region = 100};
  int whole = 0, parts = 0;
  for (const unsigned seed : {1U, 2U, 3U}) {
    GrowingCampus growing(seed);
    const PoseGraph all = makeCampus(4000, seed).graph;
    Optimiser optimiser(kLocal);
    for (int i = 0; i < 40; ++i) {
      const auto ends = growing.close(all);
      const auto before = posesOf(growing.campus.graph);
      const OptimiserReport report = optimiser.optimise(growing.campus.graph, ends);
      (report.whole ? whole : parts) += 1;
      if (report.whole) continue;
      int moved = 0;
      for (int node = 0; node < growing.campus.graph.size(); ++node)
        moved += growing.campus.graph.pose(node) != before[static_cast<std::size_t>(node)];
      EXPECT_LE(2 * moved, growing.campus.graph.size()) << seed << ' ' << i;
    }
    PoseGraph thorough = growing.campus.graph;
    Optimiser(kThorough).optimise(thorough);
    EXPECT_LT(difference(growing.campus.graph.poses(), thorough.poses()), 0.06) << seed;
  }
  EXPECT_GT(whole, 20);
  EXPECT_GT(parts, 20);
}

TEST(Optimiser, GoesFartherWhereAClosureMovesMore) {
  Square square(1);
  Optimiser all(kThorough), local({.region = 20});
  all.optimise(square.graph);
  local.optimise(square.graph);
  PoseGraph expected = square.graph;
  Edge closure{
      .from = 5, .to = 25, .T_from_to = between(square.graph.pose(5), square.graph.pose(25) * Pose2{0.3, 0, 0})};
  closure.information = Eigen::Vector3d(2500.0, 2500.0, 4e4).asDiagonal();  // no closure: a single optimum
  square.graph.addEdge(closure);
  expected.addEdge(closure);
  EXPECT_TRUE(local.optimise(square.graph, std::array{5, 25}).whole) << "half of the square is not enough";
  all.optimise(expected);
  const auto seenFromTheFirst = [](const PoseGraph& graph) {  // which is held by the last solution alone
    auto poses = posesOf(graph);
    for (Pose2& pose : poses) pose = between(graph.pose(0), pose);
    return poses;
  };
  EXPECT_LT(difference(seenFromTheFirst(square.graph), seenFromTheFirst(expected)), 0.005);
}

TEST(Optimiser, RightClosuresOutweighAWrongOne) {
  for (const unsigned seed : {1U, 2U, 3U, 4U, 5U}) {
    Square square(seed);
    PoseGraph without = square.graph;
    Edge wrong{.from = 3, .to = 55, .T_from_to = {2.0, 1.0, 1.0}, .kind = EdgeKind::kLoopClosure};
    wrong.information = Eigen::Vector3d(2500.0, 2500.0, 4e4).asDiagonal();
    square.graph.addEdge(wrong);
    Optimiser().optimise(without);
    Optimiser().optimise(square.graph);
    EXPECT_LT(difference(square.graph.poses(), without.poses()), 0.03) << seed;
  }
}

TEST(Optimiser, ARevokedEdgeCountsForNothing) {
  Square square(1);
  PoseGraph without = square.graph;
  Edge wrong{.from = 3, .to = 55, .T_from_to = {2.0, 1.0, 1.0}, .kind = EdgeKind::kMotion};
  wrong.information = 1e4 * Eigen::Matrix3d::Identity();
  const int id = square.graph.addEdge(wrong);
  Optimiser optimiser(kThorough);
  optimiser.optimise(square.graph);
  square.graph.revoke(id);
  optimiser.optimise(square.graph);
  Optimiser(kThorough).optimise(without);
  EXPECT_LT(difference(square.graph.poses(), without.poses()), 1e-6);
}

TEST(Optimiser, FollowsAGraphThatGrows) {
  Campus campus = makeCampus(1000, 5);
  PoseGraph at_once = campus.graph;
  Optimiser optimiser(kThorough);
  optimiser.optimise(campus.graph);
  for (const Edge& closure : campus.closures) {
    campus.graph.addEdge(closure);
    at_once.addEdge(closure);
    optimiser.optimise(campus.graph);
  }
  Optimiser(kThorough).optimise(at_once);
  EXPECT_LT(difference(campus.graph.poses(), at_once.poses()), 1e-4);
}

TEST(Optimiser, StaysPutAlongABlindDirection) {
  PoseGraph graph;  // a corridor along x: the edge knows y and heading only
  graph.addNode({});
  graph.addNode({5.0, 0.3, 0.0});
  const Eigen::Matrix3d blind = Eigen::Vector3d(0.0, 1e4, 1e4).asDiagonal();
  graph.addEdge({.from = 0, .to = 1, .T_from_to = {4.0, 0.1, 0.0}, .information = blind});
  EXPECT_TRUE(Optimiser().optimise(graph).converged);
  EXPECT_EQ(graph.pose(1).x, 5.0);
  EXPECT_NEAR(graph.pose(1).y, 0.1, 1e-6);
}

TEST(Optimiser, ABlindClosureCorrectsAcrossTheCorridorOnly) {
  Square square(1);
  const auto count = static_cast<int>(square.graph.edges().size());
  for (int edge = 0; edge < count; ++edge) {
    if (square.graph.edges()[static_cast<std::size_t>(edge)].kind == EdgeKind::kLoopClosure) square.graph.revoke(edge);
  }
  const Pose2 before = between(square.graph.pose(0), square.graph.pose(45));
  Edge blind{.from = 0, .to = 45, .T_from_to = before, .kind = EdgeKind::kLoopClosure};
  blind.T_from_to.x += 1.0;
  blind.information = Eigen::Matrix3d::Zero();
  blind.information(2, 2) = 1e6;
  blind.T_from_to.theta += 0.02;
  square.graph.addEdge(blind);
  EXPECT_TRUE(Optimiser(kThorough).optimise(square.graph).converged);
  const Pose2 after = between(square.graph.pose(0), square.graph.pose(45));
  EXPECT_NEAR(wrapAngle(after.theta - before.theta), 0.02, 0.002);
  EXPECT_LT(distance(after, before), 0.2);
}

TEST(Optimiser, ANodeThatNothingJoinsHindersNoOther) {
  for (const bool joined_by_revoked : {false, true}) {
    Square square(1);
    PoseGraph expected = square.graph;
    const int lonely = square.graph.addNode({7.0, 8.0, 0.9});
    if (joined_by_revoked) square.graph.revoke(square.graph.addEdge({.from = 0, .to = lonely, .T_from_to = {}}));
    EXPECT_TRUE(Optimiser(kThorough).optimise(square.graph).converged);
    Optimiser(kThorough).optimise(expected);
    EXPECT_LT(difference(square.graph.poses().first(static_cast<std::size_t>(lonely)), expected.poses()), 1e-6);
    EXPECT_EQ(square.graph.pose(lonely), (Pose2{7.0, 8.0, 0.9}));
  }
}

TEST(Optimiser, APartThatFloatsFreelyIsSolvedWhereItLies) {
  Square square(1);
  PoseGraph expected = square.graph;
  const int first = square.graph.addNode({50.0, 0.0, 1.0});
  const int second = square.graph.addNode({52.0, 0.0, 1.0});
  const Pose2 measured{1.0, 0.2, 0.1};
  square.graph.addEdge({.from = first, .to = second, .T_from_to = measured});
  ASSERT_TRUE(std::isfinite(Optimiser(kThorough).optimise(square.graph).cost_after));
  Optimiser(kThorough).optimise(expected);
  EXPECT_LT(difference(square.graph.poses().first(static_cast<std::size_t>(first)), expected.poses()), 1e-5);
  const std::array solved{between(square.graph.pose(first), square.graph.pose(second))}, wanted{measured};
  EXPECT_LT(difference(solved, wanted), 1e-5);
  EXPECT_LT(distance(square.graph.pose(first), {50.0, 0.0, 0.0}), 3.0);
}

TEST(Optimiser, LeavesThePosesOfUnsolvableProblemsAsTheyWere) {
  const double nan = std::numeric_limits<double>::quiet_NaN(), infinity = std::numeric_limits<double>::infinity();
  const auto expectUntouched = [](PoseGraph graph, const char* what) {
    const auto before = posesOf(graph);
    EXPECT_FALSE(Optimiser().optimise(graph).converged) << what;
    for (int i = 0; i < graph.size(); ++i) {
      if (isFinite(before[static_cast<std::size_t>(i)])) {
        EXPECT_EQ(graph.pose(i), before[static_cast<std::size_t>(i)]) << what;
      }
    }
  };
  for (const double bad : {nan, infinity}) {
    Square measurement(1), information(1), pose(1);
    measurement.graph.addEdge({.from = 2, .to = 60, .T_from_to = {bad, 0.0, 0.0}, .kind = EdgeKind::kLoopClosure});
    expectUntouched(measurement.graph, "measurement");
    information.graph.addEdge({.from = 2,
                               .to = 60,
                               .T_from_to = {},
                               .information = bad * Eigen::Matrix3d::Identity(),
                               .kind = EdgeKind::kLoopClosure});
    expectUntouched(information.graph, "information");
    pose.graph.setPose(30, {bad, 0.0, 0.0});
    expectUntouched(pose.graph, "pose");
  }
  Square negative(1);  // no information matrix at all: the cost has no minimum
  negative.graph.addEdge({.from = 79,
                          .to = 80,
                          .T_from_to = {},
                          .information = -1e9 * Eigen::Matrix3d::Identity(),
                          .kind = EdgeKind::kMotion});
  expectUntouched(negative.graph, "negative information");
}

TEST(Optimiser, DoesNothingWithoutTwoNodes) {
  PoseGraph graph;
  EXPECT_EQ(Optimiser().optimise(graph).iterations, 0);
  graph.addNode({1, 2, 3});
  EXPECT_EQ(Optimiser().optimise(graph).iterations, 0);
  EXPECT_EQ(graph.pose(0), (Pose2{1, 2, 3}));
}

TEST(Optimiser, TheOrderOfNodesAndEdgesDoesNotMatter) {
  std::mt19937 random(1);
  for (int trial = 0; trial < 20; ++trial) {
    PoseGraph graph = tangle(30, random), shuffled;
    std::vector<int> order(30);  // node 0 stays: it is the one that is fixed
    std::iota(order.begin(), order.end(), 0);
    std::shuffle(order.begin() + 1, order.end(), random);
    std::vector<int> place(order.size());
    for (std::size_t i = 0; i < order.size(); ++i) {
      shuffled.addNode(graph.pose(order[i]));
      place[static_cast<std::size_t>(order[i])] = static_cast<int>(i);
    }
    std::vector<Edge> edges(graph.edges().begin(), graph.edges().end());
    std::shuffle(edges.begin(), edges.end(), random);
    for (Edge edge : edges) {
      edge.from = place[static_cast<std::size_t>(edge.from)];
      edge.to = place[static_cast<std::size_t>(edge.to)];
      shuffled.addEdge(edge);
    }
    Optimiser(kThorough).optimise(graph);
    Optimiser(kThorough).optimise(shuffled);
    for (int i = 0; i < graph.size(); ++i) {
      const std::array a{graph.pose(i)}, b{shuffled.pose(place[static_cast<std::size_t>(i)])};
      ASSERT_LT(difference(a, b), 1e-5) << "trial " << trial << ", node " << i;
    }
  }
}

TEST(Optimiser, AMapThatIsMovedHasAnOptimumThatIsMoved) {
  std::mt19937 random(1);
  for (const Pose2& motion : {Pose2{100.0, -50.0, 0.0}, Pose2{0.0, 0.0, 3.0}, Pose2{-7.0, 3.0, -1.2}}) {
    PoseGraph graph = tangle(30, random), moved = graph;
    for (int i = 0; i < moved.size(); ++i) moved.setPose(i, motion * moved.pose(i));
    Optimiser(kThorough).optimise(graph);
    Optimiser(kThorough).optimise(moved);
    auto expected = posesOf(graph);
    for (Pose2& pose : expected) pose = motion * pose;
    EXPECT_LT(difference(moved.poses(), expected), 1e-5);
  }
}

}  // namespace
}  // namespace slam::optimiser_test
