// SPDX-License-Identifier: BSD-3-Clause
#include "matching/linearisation.hpp"

#include <cmath>
#include <gtest/gtest.h>
#include <random>

#include "matching/scanning.hpp"

namespace slam::linearisation_test {
namespace {

using test::Room;
using test::scanPoints;

constexpr double kGate = 0.5;  // [m]
constexpr Pose2 kPose{0.02, -0.01, 0.01};

/// A room with posts and points that may slide, met often and seldom, and a scan of it with noise.
struct Met {
  Reference reference;
  ScanPoints points;

  explicit Met(unsigned seed) {
    std::mt19937 random(seed);
    for (int i = 0; i < 3; ++i) {
      reference.add({}, scanPoints(Room{.range_sigma = 0.01}, {}, random));
      reference.add({}, posts(i == 0));
    }
    points = scanPoints(Room{.range_sigma = 0.01}, {}, random);
    const ScanPoints more = posts(true);
    points.insert(points.end(), more.begin(), more.end());
    points.push_back({.position = {500.0, 0.0}, .range = 500.0});  // beyond the window
  }

 private:
  static ScanPoints posts(bool grazing) {
    ScanPoints posts;
    for (int i = 0; i < 7; ++i)
      posts.push_back({.position = {-0.9 + 0.3 * i, 0.4}, .range = 1.0, .grazing = grazing && i % 2 == 0});
    return posts;
  }
};

/// The sums by their definition, point by point and in double precision.
Linearisation byDefinition(const Met& met, const MatchConfig& config) {
  Linearisation sums;
  const PointTransform T(kPose);
  for (const ScanPoint& point : met.points) {
    const Eigen::Vector2d p = T * point.position, lever = T.turned(point.position);
    if (!met.reference.covers(p)) continue;
    ++sums.covered;
    const Surfel* surfel = met.reference.nearest(p, kGate);
    if (surfel == nullptr) continue;
    const Eigen::Vector2d d = p - Eigen::Vector2d(surfel->x, surfel->y);
    if (d.norm() > kGate) continue;
    const bool sliding = surfel->grazing && surfel->observations < config.grazing_observations;
    const bool line = surfel->isLine() || sliding;
    Eigen::Vector2d n(surfel->nx, surfel->ny);
    if (sliding) n = Eigen::Vector2d(-lever.y(), lever.x()).normalized();
    if (surfel->isLine() && point.hasNormal() && n.dot(T.turned(point.normal)) < config.same_face) continue;
    Eigen::Matrix<double, 2, 3> J;
    J << 1.0, 0.0, -lever.y(), 0.0, 1.0, lever.x();
    const Eigen::RowVector3d across = n.transpose() * J;
    const double e = n.dot(d), squared = line ? e * e : d.squaredNorm();
    const double share = surfel->isLine() && !sliding ? 1.0 : config.point_weight;
    const double w = share * surfel->observations / (1.0 + surfel->observations) /
                     (1.0 + squared / (config.kernel_scale * config.kernel_scale));
    NormalEquations& equations = sums.equations;
    equations.H += line ? Eigen::Matrix3d(w * across.transpose() * across) : Eigen::Matrix3d(w * J.transpose() * J);
    equations.g += line ? Eigen::Vector3d(w * across.transpose() * e) : Eigen::Vector3d(w * J.transpose() * d);
    const Eigen::RowVector3d along(-n.y(), n.x(), n.dot(lever));
    if (line) equations.spurious += w * surfel->normal_variance * along.transpose() * along;
    equations.weight += w;
    equations.squared_error += w * squared;
    ++equations.pairs;
    if (squared >= config.overlap_distance * config.overlap_distance) continue;
    ++sums.agreeing;
    sums.agreeing_error += squared;
    sums.known += surfel->observations >= config.known_observations;
  }
  return sums;
}

TEST(Linearisation, SumsAreThoseOfEachPairAlone) {
  const MatchConfig config{.known_observations = 3.0};
  for (const unsigned seed : {1U, 2U, 3U, 4U, 5U}) {
    const Met met(seed);
    const Linearisation found = linearise(met.reference, met.points, kPose, kGate, config.kernel_scale, config);
    const Linearisation wanted = byDefinition(met, config);
    ASSERT_GT(wanted.equations.pairs, 100);
    ASSERT_LT(wanted.covered, static_cast<int>(met.points.size()));
    ASSERT_GT(wanted.known, 0);
    EXPECT_EQ(found.covered, wanted.covered);
    EXPECT_EQ(found.equations.pairs, wanted.equations.pairs);
    EXPECT_EQ(found.agreeing, wanted.agreeing);
    EXPECT_EQ(found.known, wanted.known);
    EXPECT_TRUE(found.equations.H.isApprox(wanted.equations.H, 1e-5)) << found.equations.H << "\n"
                                                                      << wanted.equations.H;
    EXPECT_TRUE(found.equations.spurious.isApprox(wanted.equations.spurious, 1e-4));
    EXPECT_TRUE(found.equations.g.isApprox(wanted.equations.g, 1e-3)) << found.equations.g << "\n"
                                                                      << wanted.equations.g;
    EXPECT_NEAR(found.equations.weight, wanted.equations.weight, 1e-4 * wanted.equations.weight);
    EXPECT_NEAR(found.equations.squared_error, wanted.equations.squared_error, 1e-3 * wanted.equations.squared_error);
    EXPECT_NEAR(found.agreeing_error, wanted.agreeing_error, 1e-3 * wanted.agreeing_error);
  }
}

TEST(Linearisation, APartsPullIsItsGradientAlone) {
  const MatchConfig config;
  const Met met(1);
  Eigen::Matrix3d wanted = Eigen::Matrix3d::Zero();
  int parts = 0;
  for (std::size_t first = 0, end = 0; first < met.points.size(); first = end, ++parts) {
    const auto belongs = [&](std::size_t i) {
      if ((met.points[i].position - met.points[i - 1].position).norm() > config.part_gap) return false;
      const bool lines = met.points[i].hasNormal() && met.points[first].hasNormal();
      return !lines || met.points[i].normal.dot(met.points[first].normal) > config.part_bend;
    };
    for (end = first + 1; end < met.points.size() && belongs(end);) ++end;
    const std::span<const ScanPoint> part = std::span(met.points).subspan(first, end - first);
    const Eigen::Vector3d g =
        linearise(met.reference, part, kPose, config.final_pair_distance, config.kernel_scale, config).equations.g;
    wanted += g * g.transpose();
  }
  ASSERT_GT(parts, 4);
  const Eigen::Matrix3d found = pullsOfParts(met.reference, met.points, kPose, config);
  EXPECT_TRUE(found.isApprox(wanted, 1e-4)) << found << "\n" << wanted;
}

}  // namespace
}  // namespace slam::linearisation_test
