// SPDX-License-Identifier: BSD-3-Clause
// What matchPointToLine() sums up, against numeric derivatives of the errors that it is defined by.
#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <array>
#include <cmath>
#include <functional>
#include <gtest/gtest.h>
#include <random>
#include <span>
#include <vector>

#include "matching/plicp.hpp"

namespace slam::plicp_equations_test {
namespace {

constexpr double kSpacing = 0.8;  // [m] between surfels: no point has another one near
constexpr Pose2 kTruth{0.31, -0.17, 0.4};

/// Pieces of wall and posts all over a place, each met once by the scan.
struct Scene {
  struct Piece {
    Eigen::Vector2d position, normal;  // normal zero: a post
    int observations;
  };
  std::vector<Piece> pieces;
  Reference reference;
  ScanPoints points;

  /// @param line whether a piece is a wall @param error [m] of its point, across a wall or in any direction
  Scene(const std::function<bool(int)>& line, double error, unsigned seed) {
    std::mt19937 random(seed);
    std::uniform_real_distribution<double> direction(-3.1, 3.1), unit(-1.0, 1.0);
    std::normal_distribution<double> normal;
    for (int row = -4; row <= 4; ++row) {
      for (int column = -2; column <= 6; ++column) {
        const double angle = direction(random);
        const bool is_line = line(static_cast<int>(pieces.size()));
        pieces.push_back({{kSpacing * column + 0.1 * unit(random), kSpacing * row + 0.1 * unit(random)},
                          is_line ? Eigen::Vector2d(std::cos(angle), std::sin(angle)) : Eigen::Vector2d::Zero(),
                          1 + static_cast<int>(pieces.size()) % 7});
      }
    }
    const Pose2 T_base_ref = kTruth.inverse();
    for (const Piece& piece : pieces) {
      const ScanPoint surfel{.position = piece.position, .normal = piece.normal, .normal_variance = 1e-6, .range = 1.0};
      for (int i = 0; i < piece.observations; ++i) reference.add({}, std::span(&surfel, 1));
      Eigen::Vector2d p = piece.position;
      if (piece.normal.isZero()) {
        p += error * Eigen::Vector2d(normal(random), normal(random));
      } else {
        const Eigen::Vector2d along(-piece.normal.y(), piece.normal.x());
        p += error * normal(random) * piece.normal + 0.03 * unit(random) * along;
      }
      const PointTransform T(T_base_ref);
      points.push_back(
          {.position = T * p, .normal = T.turned(piece.normal), .normal_variance = 1e-6, .range = (T * p).norm()});
    }
  }

  double trust(std::size_t i) const {
    const double share = pieces[i].observations / (1.0 + pieces[i].observations);
    return pieces[i].normal.isZero() ? share * MatchConfig{}.point_weight : share;
  }
  /// Errors of one pair at a pose: across a wall, or both coordinates.
  Eigen::Vector2d errors(std::size_t i, const Eigen::Vector3d& T) const {
    const Eigen::Vector2d d = Pose2{T.x(), T.y(), T.z()} * points[i].position - pieces[i].position;
    return pieces[i].normal.isZero() ? d : Eigen::Vector2d(pieces[i].normal.dot(d), 0.0);
  }
  /// Half the sum that is minimised, by Cauchy's kernel.
  double cost(const Eigen::Vector3d& T, double kernel) const {
    double sum = 0.0;
    for (std::size_t i = 0; i < pieces.size(); ++i) {
      sum += 0.5 * trust(i) * kernel * kernel * std::log1p(errors(i, T).squaredNorm() / (kernel * kernel));
    }
    return sum;
  }
  /// Sum of w J^T J with numeric Jacobians.
  Eigen::Matrix3d information(const Eigen::Vector3d& T) const {
    constexpr double kStep = 1e-5;
    Eigen::Matrix3d H = Eigen::Matrix3d::Zero();
    for (std::size_t i = 0; i < pieces.size(); ++i) {
      Eigen::Matrix<double, 2, 3> J;
      for (int k = 0; k < 3; ++k) {
        const Eigen::Vector3d d = kStep * Eigen::Vector3d::Unit(k);
        J.col(k) = (errors(i, T + d) - errors(i, T - d)) / (2.0 * kStep);
      }
      H += trust(i) * J.transpose() * J;
    }
    return H;
  }
};

MatchConfig exact() {
  MatchConfig config;
  config.translation_tolerance = config.rotation_tolerance = 1e-9;
  config.max_iterations = 300;
  return config;
}

struct Kind {
  const char* name;
  std::function<bool(int)> line;
};
const std::array<Kind, 3> kKinds{Kind{"walls", [](int) { return true; }}, Kind{"posts", [](int) { return false; }},
                                 Kind{"both", [](int i) { return i % 2 == 0; }}};

TEST(PlIcpEquations, EndWhereTheNumericGradientOfTheErrorsVanishes) {
  for (const Kind& kind : kKinds) {
    for (unsigned seed = 1; seed <= 5; ++seed) {
      const Scene scene(kind.line, 0.03, seed);
      const MatchResult result = matchPointToLine(scene.reference, scene.points, {0.33, -0.20, 0.38}, exact());
      ASSERT_EQ(result.status, MatchStatus::kConverged) << kind.name << seed;
      ASSERT_EQ(result.pairs, static_cast<int>(scene.pieces.size())) << kind.name << seed;
      constexpr double kStep = 1e-5;
      const Eigen::Vector3d T = result.T_ref_base.vector();
      Eigen::Vector3d gradient;
      for (int k = 0; k < 3; ++k) {
        const Eigen::Vector3d d = kStep * Eigen::Vector3d::Unit(k);
        gradient[k] = (scene.cost(T + d, 0.05) - scene.cost(T - d, 0.05)) / (2.0 * kStep);
      }
      const Eigen::Vector3d step = scene.information(T).ldlt().solve(gradient);
      EXPECT_LT(step.norm(), 2e-6) << kind.name << seed << ": " << step.transpose();
      EXPECT_GT((T - kTruth.vector()).norm(), 1e-3) << "the errors do move it";
    }
  }
}

TEST(PlIcpEquations, TheCovarianceIsThatOfTheNumericJacobians) {
  for (const Kind& kind : kKinds) {
    for (unsigned seed = 1; seed <= 5; ++seed) {
      const Scene scene(kind.line, 0.0, seed);
      for (const double sigma : {0.01, 0.02}) {
        MatchConfig config = exact();
        config.range_sigma = sigma;
        const MatchResult result = matchPointToLine(scene.reference, scene.points, {0.33, -0.20, 0.38}, config);
        ASSERT_EQ(result.status, MatchStatus::kConverged) << kind.name << seed;
        EXPECT_LT((result.T_ref_base.vector() - kTruth.vector()).norm(), 1e-4);
        const Eigen::Matrix3d expected = sigma * sigma * scene.information(kTruth.vector()).inverse();
        const Eigen::Vector3d scale = expected.diagonal().cwiseSqrt().cwiseInverse();
        const Eigen::Matrix3d error = scale.asDiagonal() * (result.covariance - expected) * scale.asDiagonal();
        EXPECT_LT(error.cwiseAbs().maxCoeff(), 0.02) << kind.name << seed << "\n"
                                                     << result.covariance << "\nexpected:\n"
                                                     << expected;
      }
    }
  }
}

TEST(PlIcpEquations, ErrorsBeyondTheLidarsNoiseMakeTheCovarianceLarger) {
  const Scene scene([](int) { return true; }, 0.03, 1);
  MatchConfig config = exact();
  config.range_sigma = 0.001;
  const MatchResult result = matchPointToLine(scene.reference, scene.points, kTruth, config);
  ASSERT_EQ(result.status, MatchStatus::kConverged);
  double weighted = 0.0, weight = 0.0, squares = 0.0;
  for (std::size_t i = 0; i < scene.pieces.size(); ++i) {
    const double e2 = scene.errors(i, result.T_ref_base.vector()).squaredNorm();
    const double w = scene.trust(i) / (1.0 + e2 / (0.05 * 0.05));
    weight += w;
    weighted += w * e2;
    squares += e2;
  }
  const double variance = (result.covariance - result.tension).inverse().trace();
  const double of_sigma = scene.information(result.T_ref_base.vector()).trace();
  EXPECT_NEAR(variance * (weighted / weight) / of_sigma, 0.8, 0.2) << "of the pairs' weights";
  EXPECT_NEAR(result.residual, std::sqrt(squares / static_cast<double>(scene.pieces.size())), 1e-3);
}

TEST(PlIcpEquations, TheOtherFaceOfAThinWallIsNoPartner) {
  const Scene scene([](int) { return true; }, 0.01, 2);
  const auto pairsTurned = [&](double angle, bool normals) {
    ScanPoints points = scene.points;
    for (ScanPoint& point : points) {
      point.normal = normals ? Pose2{0, 0, angle} * point.normal : Eigen::Vector2d::Zero().eval();
    }
    return matchPointToLine(scene.reference, points, kTruth).pairs;
  };
  const int all = static_cast<int>(scene.pieces.size());
  EXPECT_EQ(pairsTurned(0.0, true), all);
  EXPECT_EQ(pairsTurned(std::acos(0.25), true), all);
  EXPECT_EQ(pairsTurned(-std::acos(0.25), true), all);
  EXPECT_EQ(pairsTurned(std::acos(0.15), true), 0);
  EXPECT_EQ(pairsTurned(-std::acos(0.15), true), 0);
  EXPECT_EQ(pairsTurned(3.14, true), 0) << "the other face";
  EXPECT_EQ(pairsTurned(3.14, false), all) << "a point without a normal may lie on either";
}

TEST(PlIcpEquations, APairLiesWithinTheGate) {
  for (const auto& [distance, pairs] : {std::pair(0.45, 10), std::pair(0.55, 0)}) {
    Scene scene([](int) { return false; }, 0.0, 3);
    for (int i = 0; i < 10; ++i) {  // beside the outermost posts, away from all others
      const std::size_t row = static_cast<std::size_t>(9 * (i % 9));
      const Eigen::Vector2d p = scene.pieces[row].position - Eigen::Vector2d(distance, 0.0);
      scene.points.push_back({.position = kTruth.inverse() * p, .range = 1.0});
    }
    const MatchResult result = matchPointToLine(scene.reference, scene.points, kTruth);
    ASSERT_EQ(result.status, MatchStatus::kConverged);
    EXPECT_EQ(result.pairs, static_cast<int>(scene.pieces.size()) + pairs) << distance;
  }
}

TEST(PlIcpEquations, CountsWhatAgreesAndWhatIsKnownWell) {
  for (const bool line : {true, false}) {
    Scene scene([&](int) { return line; }, 0.0, 4);
    int known = 0;
    const int all = static_cast<int>(scene.pieces.size());
    for (std::size_t i = 0; i < scene.pieces.size(); ++i) known += scene.pieces[i].observations >= 5;
    const MatchResult result = matchPointToLine(scene.reference, scene.points, kTruth);
    EXPECT_DOUBLE_EQ(result.overlap, 1.0);
    EXPECT_DOUBLE_EQ(result.known_ratio, static_cast<double>(known) / all);
    const auto overlapWith = [&](double off) {  // every fifth point stands off its piece
      ScanPoints points = scene.points;
      for (std::size_t i = 0; i < points.size(); i += 5) {
        const Eigen::Vector2d across = line ? points[i].normal : Eigen::Vector2d(0.6, 0.8);
        points[i].position += (i % 2 == 0 ? off : -off) * across;
      }
      return overlapAt(scene.reference, points, kTruth, 0.10);
    };
    EXPECT_DOUBLE_EQ(overlapWith(0.09), 1.0);
    EXPECT_NEAR(overlapWith(0.11), 0.8, 0.01);
  }
}

TEST(PlIcpEquations, LittleAgreementOrFewPairsAreNoMatch) {
  const Scene scene([](int) { return true; }, 0.0, 5);
  MatchConfig config;
  ScanPoints points = scene.points;
  for (std::size_t i = 0; i < points.size(); i += 3) {  // a third stands off its wall, to either side
    points[i].position += (i % 2 == 0 ? 0.2 : -0.2) * points[i].normal;
  }
  const MatchResult result = matchPointToLine(scene.reference, points, kTruth, config);
  ASSERT_EQ(result.status, MatchStatus::kConverged);
  EXPECT_NEAR(result.overlap, 2.0 / 3.0, 0.02);
  config.min_overlap = result.overlap + 0.01;
  EXPECT_EQ(matchPointToLine(scene.reference, points, kTruth, config).status, MatchStatus::kLowOverlap);
  config.min_overlap = result.overlap - 0.01;
  config.min_pairs = static_cast<int>(scene.pieces.size());
  EXPECT_EQ(matchPointToLine(scene.reference, points, kTruth, config).status, MatchStatus::kConverged);
  ++config.min_pairs;
  EXPECT_EQ(matchPointToLine(scene.reference, points, kTruth, config).status, MatchStatus::kTooFewPairs);
  config = {};
  config.max_iterations = 2;
  EXPECT_EQ(matchPointToLine(scene.reference, points, {0.4, -0.3, 0.3}, config).status, MatchStatus::kIterationLimit);
}

TEST(PlIcpEquations, AFarGuessNeedsTheSearchThatIsGiven) {
  const Scene scene([](int i) { return i % 4 != 0; }, 0.0, 6);
  const Pose2 guess{kTruth.x + 0.25, kTruth.y - 0.2, kTruth.theta};
  MatchConfig config;
  config.initial_pair_distance = 0.1;
  config.final_pair_distance = 0.1;
  EXPECT_GT(
      (matchPointToLine(scene.reference, scene.points, guess, config).T_ref_base.translation() - kTruth.translation())
          .norm(),
      0.1);
  config.search_translation = 0.4;
  EXPECT_LT(
      (matchPointToLine(scene.reference, scene.points, guess, config).T_ref_base.translation() - kTruth.translation())
          .norm(),
      0.005);
}

TEST(PlIcpEquations, WhatNoisyNormalsFeignAlongAWallIsTakenOffHoweverItLies) {
  for (const double bearing : {0.0, 0.8, -0.8, 2.3}) {
    const PointTransform wall({0.5, -0.3, bearing});  // two walls along its x axis
    std::mt19937 random(7);
    std::normal_distribution<double> error(0.0, 0.2);
    Reference reference;
    ScanPoints points;
    for (int i = -20; i <= 20; ++i) {
      for (const double side : {-1.5, 1.5}) {
        const Eigen::Vector2d p = wall * Eigen::Vector2d(0.4 * i, side);
        const double angle = error(random);
        const Eigen::Vector2d normal = wall.turned(Pose2{0, 0, angle} * Eigen::Vector2d(0.0, -side / 1.5));
        const ScanPoint surfel{.position = p, .normal = normal, .normal_variance = 0.04, .range = 3.0};
        reference.add({}, std::span(&surfel, 1));
        points.push_back(surfel);
      }
    }
    const MatchResult result = matchPointToLine(reference, points, {});
    ASSERT_EQ(result.observable, 2) << bearing;
    const Eigen::Vector2d along = wall.turned({1.0, 0.0});
    EXPECT_GT(std::abs(result.directions.col(2).head<2>().dot(along)), 0.95) << bearing;
  }
}

}  // namespace
}  // namespace slam::plicp_equations_test
