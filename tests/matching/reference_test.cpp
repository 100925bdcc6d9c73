// SPDX-License-Identifier: BSD-3-Clause
#include "matching/reference.hpp"

#include <cmath>
#include <gtest/gtest.h>
#include <span>
#include <sys/resource.h>
#include <utility>

#include "matching/scanning.hpp"
#include "support/allocations.hpp"

namespace slam::reference_test {
namespace {

using test::Room;
using test::scanPoints;

ScanPoint wallPoint(double x, double y, const Eigen::Vector2d& normal, double variance = 0.01) {
  return {.position = {x, y}, .normal = normal, .normal_variance = variance, .range = 1.0};
}

TEST(Reference, AveragesTheNoiseOfManyScans) {
  const Room room{.range_sigma = 0.015};
  std::mt19937 random(1);
  Reference reference;
  for (int i = 0; i < 20; ++i) reference.add(Pose2{}, scanPoints(room, Pose2{}, random));
  double squares = 0.0;
  int count = 0;
  for (const Surfel& surfel : reference.surfels()) {
    if (!surfel.isLine() || surfel.observations < 10) continue;
    const double error = std::min(std::abs(std::abs(surfel.x) - 3.0), std::abs(std::abs(surfel.y) - 2.0));
    squares += error * error;
    ++count;
  }
  ASSERT_GT(count, 100);
  EXPECT_LT(std::sqrt(squares / count), 0.008);  // half of one range's sigma
}

TEST(Reference, FindsTheNearestSurfelGiveOrTakeHalfACell) {
  std::mt19937 random(2);
  Reference reference;
  reference.add(Pose2{}, scanPoints(Room{.range_sigma = 0.005}, Pose2{}, random));
  std::uniform_real_distribution<double> x(-3.2, 3.2), y(-2.2, 2.2);
  int found = 0;
  for (int i = 0; i < 2000; ++i) {
    const Eigen::Vector2d p(x(random), y(random));
    double nearest = 1e9;
    for (const Surfel& surfel : reference.surfels()) {
      nearest = std::min(nearest, (Eigen::Vector2d(surfel.x, surfel.y) - p).norm());
    }
    const Surfel* surfel = reference.nearest(p, 0.2);
    if (nearest < 0.2) {
      ASSERT_NE(surfel, nullptr);
      EXPECT_LT((Eigen::Vector2d(surfel->x, surfel->y) - p).norm(), nearest + 0.08);
      ++found;
    }
  }
  EXPECT_GT(found, 100);
}

TEST(Reference, APointMaySlideUntilItIsMetAsOneThatMayNot) {
  Reference reference;
  const auto meet = [&](double x, bool grazing) {
    const ScanPoint point{.position = {x, 1.0}, .range = 8.0, .grazing = grazing};
    reference.add(Pose2{}, std::span(&point, 1));
    return *reference.nearest({8.0, 1.0}, 0.2);
  };
  EXPECT_TRUE(meet(8.0, true).grazing);
  EXPECT_TRUE(meet(8.02, true).grazing);
  EXPECT_FALSE(meet(8.01, false).grazing);
  EXPECT_FALSE(meet(8.0, true).grazing);
  EXPECT_EQ(reference.size(), 1);
}

TEST(Reference, DoesNotGrowWhereItIsComplete) {
  const Room room{.range_sigma = 0.01};
  std::mt19937 random(3);
  Reference reference;
  for (int i = 0; i < 30; ++i) reference.add(Pose2{}, scanPoints(room, Pose2{}, random));
  const int before = reference.size();
  for (int i = 0; i < 30; ++i) reference.add(Pose2{}, scanPoints(room, Pose2{}, random));
  EXPECT_LT(reference.size() - before, before / 20);
}

TEST(Reference, OfAScanThatPartIsNewThatItWouldDrawAnew) {
  Reference reference;
  const auto wall = [](double begin, double y) {
    ScanPoints points;
    for (int i = 0; i < 100; ++i) points.push_back(wallPoint(begin + 0.01 * i, y, {0.0, -1.0}));
    return points;
  };
  EXPECT_EQ(reference.newShare({}, {}), 0.0);
  EXPECT_EQ(reference.newShare({}, wall(0.0, 2.0)), 1.0);
  reference.add({}, wall(0.0, 2.0));  // ten beams on each surfel
  EXPECT_NEAR(reference.newShare({}, wall(0.0, 2.0)), 0.0, 0.05);
  EXPECT_NEAR(reference.newShare({}, wall(0.3, 2.0)), 0.3, 0.05);
  EXPECT_NEAR(reference.newShare({0.3, 0.0, 0.0}, wall(0.0, 2.0)), 0.3, 0.05) << "by where the scan lies";
  EXPECT_EQ(reference.newShare({}, wall(0.0, 2.1)), 1.0) << "another wall";
  const ScanPoint face = wallPoint(0.5, 2.0, {0.0, 1.0}), corner{.position = {0.0, 2.01}, .range = 2.0};
  EXPECT_EQ(reference.newShare({}, std::span(&face, 1)), 1.0) << "the other face";
  EXPECT_EQ(reference.newShare({}, std::span(&corner, 1)), 0.0) << "on no line, but beside one";
}

TEST(Reference, ForgetsWhatLeavesItsWindowAndKeepsTheRest) {
  std::mt19937 random(4);
  Reference reference({.extent = 50.0, .max_surfels = 4500});  // as many as come by twice
  const auto points = scanPoints(Room{}, Pose2{}, random);
  for (int step = 0; step < 40; ++step) {
    const Pose2 pose{3.0 * step, 0, 0};
    reference.recentre(pose.translation());
    reference.add(pose, points);
    ASSERT_NE(reference.nearest(pose * Eigen::Vector2d(3.0, 0.0), 0.2), nullptr);
    ASSERT_LT(reference.size(), 8000) << "or nothing is forgotten";
  }
  // The tables are tori: what is found at a forgotten place lies a whole window further on.
  const Surfel* alias = reference.nearest({3.0, 0.0}, 0.2);
  EXPECT_TRUE(alias == nullptr || std::abs(alias->x - 3.0F) > 25.0F);
}

TEST(Reference, TakesNoMoreSurfelsThanItsTablesCanName) {
  Reference reference({.max_surfels = 1 << 20});
  const auto at = [](int i) { return Eigen::Vector2d(0.15 * (i % 280 - 140), 0.15 * (i / 280 - 140)); };
  int added = 0;
  for (int i = 0; i < 70000; ++i) {
    const ScanPoint point = wallPoint(at(i).x(), at(i).y(), {1.0, 0.0});
    added += reference.add({}, std::span(&point, 1));
  }
  EXPECT_EQ(added, 65535);
  EXPECT_EQ(reference.size(), 65535);
  for (const int i : {0, 1, 30000, 65534}) {
    const Surfel* surfel = reference.nearest(at(i), 0.2);
    ASSERT_NE(surfel, nullptr) << i;
    EXPECT_LT((Eigen::Vector2d(surfel->x, surfel->y) - at(i)).norm(), 1e-4) << i;
  }
}

TEST(Reference, AnswersInAWindowThatMovedAsOneThatWasBuiltThere) {
  std::mt19937 random(7);
  std::uniform_real_distribution<double> beside(-8.0, 8.0), step(-30.0, 30.0), turn(-3.0, 3.0);
  for (const double extent : {12.8, 25.6, 51.2}) {
    Reference moved({.extent = extent});
    Eigen::Vector2d centre = Eigen::Vector2d::Zero();
    int found = 0;
    for (int round = 0; round < 30; ++round) {
      centre += 0.02 * extent * Eigen::Vector2d(step(random), step(random));
      moved.recentre(centre);
      for (int i = 0; i < 300; ++i) {
        const double angle = turn(random);
        const ScanPoint point =
            wallPoint(centre.x() + beside(random), centre.y() + beside(random), {std::cos(angle), std::sin(angle)});
        moved.add({}, std::span(&point, 1));
      }
      for (int i = 0; i < 1000; ++i) {
        const Eigen::Vector2d p = centre + Eigen::Vector2d(beside(random), beside(random));
        if (!moved.covers(p)) continue;
        double nearest = 1e9;
        for (const Surfel& surfel : moved.surfels()) {
          if (surfel.observations > 0.0F) nearest = std::min(nearest, (Eigen::Vector2d(surfel.x, surfel.y) - p).norm());
        }
        const Surfel* surfel = moved.nearest(p, 2.0);
        if (nearest > 1.7) continue;
        ASSERT_NE(surfel, nullptr) << extent << " m, round " << round << ": " << p.transpose();
        ASSERT_GT(surfel->observations, 0.0F) << extent << " m, round " << round;
        ASSERT_LT((Eigen::Vector2d(surfel->x, surfel->y) - p).norm(), nearest + 0.45) << extent << " m";
        ++found;
      }
    }
    EXPECT_GT(found, 5000) << extent;
  }
}

TEST(Reference, IsEmptyOnceItIsCleared) {
  std::mt19937 random(6);
  const auto points = scanPoints(Room{}, Pose2{}, random);
  std::uniform_real_distribution<double> near(-1.0, 1.0), turn(-3.0, 3.0), far(-300.0, 300.0);
  for (const double extent : {2.0, 7.0, 50.0}) {
    Reference reference({.extent = extent, .coarse_radius = 0.9});
    for (std::size_t round = 0; round < 100; ++round) {
      const Eigen::Vector2d centre{far(random), far(random)};
      reference.clear(centre);
      // One point at the centre, then also the rest: what only one wrote must go, too.
      const std::size_t first = round * points.size() / 100;
      const double theta = turn(random);
      const Eigen::Vector2d t = centre - Pose2{0.0, 0.0, theta} * points[first].position;
      reference.add({t.x(), t.y(), theta},
                    std::span(points).subspan(first, round % 2 == 0 ? 1 : points.size() - first));
      ASSERT_GT(reference.size(), 0);
      reference.clear(centre);
      EXPECT_EQ(reference.size(), 0);
      EXPECT_TRUE(reference.surfels().empty());
      for (int i = 0; i < 400; ++i) {
        const Eigen::Vector2d p = centre + Eigen::Vector2d{near(random), near(random)};
        ASSERT_EQ(reference.nearest(p, 2.0), nullptr) << "extent " << extent;
      }
    }
  }
}

TEST(Reference, IsSeenThroughFromAnotherPlaceThatMatches) {
  std::mt19937 random(5);
  const Room room{.length = 6.0, .width = 4.0, .range_sigma = 0.015};
  Reference reference;
  for (int i = 0; i < 6; ++i) reference.add(Pose2{}, scanPoints(room, Pose2{}, random));
  const Pose2 here{1.0, 0.5, 0.3};
  RangeImage image;
  image.set(scanPoints(room, here, random), Eigen::Vector2d::Zero());
  EXPECT_LT(reference.freeSpaceViolation(here, image, 2.0), 0.01);
  EXPECT_LT(reference.freeSpaceViolation(here * Pose2{0.05, -0.05, 0.02}, image, 2.0), 0.02)
      << "a match may be a little off";
  // Two of the walls agree from there.
  EXPECT_GT(reference.freeSpaceViolation(Pose2{0.0, 0.0, 1.5708} * here, image, 2.0), 0.2);
  EXPECT_EQ(reference.freeSpaceViolation(here, image, 100.0), 0.0) << "nothing is known so well";
}

TEST(Reference, DoesNotAllocateAfterConstruction) {
  std::mt19937 random(5);
  Reference reference;
  const auto points = scanPoints(Room{}, Pose2{}, random);
  EXPECT_EQ(test::allocationsDuring([&] {
              reference.add(Pose2{}, points);
              reference.recentre({60.0, 0.0});
              reference.add({60.0, 0.0, 0.0}, points);
            }),
            0U);
}

/// How many surfels a second point makes beside one at the origin, whose wall faces y.
int surfelsAfter(const ScanPoint& second, const ReferenceConfig& config = {}) {
  Reference reference(config);
  const ScanPoint first = wallPoint(0.0, 0.0, {0.0, 1.0});
  reference.add({}, std::span(&first, 1));
  reference.add({}, std::span(&second, 1));
  return reference.size();
}

TEST(Reference, MergesWhatIsNearAlongTheWallAndAcrossItAndFacesTheSameWay) {
  const Eigen::Vector2d up(0.0, 1.0);
  EXPECT_EQ(surfelsAfter(wallPoint(0.045, 0.0, up)), 1);
  EXPECT_EQ(surfelsAfter(wallPoint(0.055, 0.0, up)), 2);
  EXPECT_EQ(surfelsAfter(wallPoint(-0.055, 0.0, up)), 2);
  EXPECT_EQ(surfelsAfter(wallPoint(0.0, 0.075, up)), 1);
  EXPECT_EQ(surfelsAfter(wallPoint(0.0, -0.085, up)), 2);
  EXPECT_EQ(surfelsAfter(wallPoint(0.0, 0.085, up)), 2);
  EXPECT_EQ(surfelsAfter(wallPoint(0.0, -0.04, -up)), 2) << "the other face of a thin wall";
  EXPECT_EQ(surfelsAfter(wallPoint(0.0, 0.0, {0.79, 0.61})), 1);
  EXPECT_EQ(surfelsAfter(wallPoint(0.0, 0.0, {0.81, 0.59})), 2);
  EXPECT_EQ(surfelsAfter(wallPoint(0.11, 0.0, up), {.surfel_spacing = 0.12}), 1);
  EXPECT_EQ(surfelsAfter(wallPoint(0.0, 0.11, up), {.merge_distance = 0.12}), 1);
}

TEST(Reference, APointOnNoLineIsLostOnAWallButStandsBesideIt) {
  EXPECT_EQ(surfelsAfter(wallPoint(0.03, 0.03, Eigen::Vector2d::Zero())), 1);
  EXPECT_EQ(surfelsAfter(wallPoint(0.045, 0.03, Eigen::Vector2d::Zero())), 2);
}

TEST(Reference, AWallsPointsAreAveragedAcrossItAlone) {
  for (const double turn : {0.0, 0.9, -2.0}) {
    const Pose2 T{1.0, -0.5, turn};
    Reference reference({.max_observations = 4});
    const auto add = [&](double along, double across, double variance) {
      const ScanPoint point = wallPoint(along, across, {0.0, 1.0}, variance);
      reference.add(T, std::span(&point, 1));
    };
    add(0.0, 0.0, 0.02);
    add(0.02, 0.04, 0.01);
    const Surfel* surfel = reference.nearest(T * Eigen::Vector2d::Zero(), 0.2);
    ASSERT_NE(surfel, nullptr);
    Eigen::Vector2d there = T.inverse() * Eigen::Vector2d(surfel->x, surfel->y);
    EXPECT_NEAR(there.x(), 0.0, 1e-6) << "the spacing stays";
    EXPECT_NEAR(there.y(), 0.02, 1e-6);
    EXPECT_NEAR(surfel->normal_variance, 1.0 / (1 / 0.02 + 1 / 0.01), 1e-7);
    for (int i = 0; i < 20; ++i) add(0.0, 0.03, 0.01);
    EXPECT_EQ(surfel->observations, 4.0F) << "more makes it no stiffer";
    EXPECT_NEAR(surfel->normal_variance, 0.01 / 4, 1e-7);
    there = T.inverse() * Eigen::Vector2d(surfel->x, surfel->y);
    EXPECT_NEAR(there.y(), 0.03, 2e-4);
  }
}

TEST(Reference, AWallsNormalIsTheMeanByItsVariances) {
  Reference reference;
  for (const auto& [angle, variance] : {std::pair(0.0, 0.02), std::pair(0.3, 0.01)}) {
    const ScanPoint point = wallPoint(0.0, 0.0, {-std::sin(angle), std::cos(angle)}, variance);
    reference.add({}, std::span(&point, 1));
  }
  const Surfel* surfel = reference.nearest({0.0, 0.0}, 0.2);
  EXPECT_NEAR(std::atan2(-surfel->nx, surfel->ny), 0.2, 0.005);
  EXPECT_NEAR(std::hypot(surfel->nx, surfel->ny), 1.0, 1e-6);
}

TEST(Reference, TheWindowFollowsOnceItsMiddleHalfIsLeft) {
  Reference reference({.extent = 40.0, .coarse_radius = 2.0});
  double half = 0.0;
  while (reference.covers({half, 0.0})) half += 0.1;
  ASSERT_GT(half, 17.0);
  reference.recentre({0.49 * half, 0.0});
  EXPECT_FALSE(reference.covers({half + 0.2, 0.0})) << "it stays";
  reference.recentre({0.0, 0.52 * half});
  EXPECT_TRUE(reference.covers({0.0, 1.5 * half}));
  EXPECT_FALSE(reference.covers({0.0, -0.5 * half}));
}

TEST(Reference, LooksBeyondTheFineTableWhereItIsAskedTo) {
  Reference reference;
  const ScanPoint point = wallPoint(0.0, 0.0, {0.0, 1.0});
  reference.add({}, std::span(&point, 1));
  EXPECT_NE(reference.nearest({0.2, 0.0}, 0.1), nullptr);
  EXPECT_EQ(reference.nearest({0.6, 0.0}, 0.2), nullptr);
  EXPECT_NE(reference.nearest({0.6, 0.0}, 0.6), nullptr);
  EXPECT_NE(reference.nearest({1.8, 0.0}, 2.0), nullptr);
  EXPECT_EQ(reference.nearest({2.3, 0.0}, 5.0), nullptr) << "no table knows so far";
}

TEST(Reference, AFewSurfelsGiveNoPlace) {
  ScanPoints far;
  for (int i = 0; i < 400; ++i) {
    const double bearing = -3.1 + 0.0155 * i;
    far.push_back({.position = 6.0 * Eigen::Vector2d(std::cos(bearing), std::sin(bearing))});
  }
  RangeImage image;
  image.set(far, Eigen::Vector2d::Zero());
  for (const auto& [count, share] : {std::pair(19, 0.0), std::pair(20, 1.0)}) {
    Reference reference;
    for (int i = 0; i < count; ++i) {
      const ScanPoint point = wallPoint(2.0, 0.1 * i - 1.0, {-1.0, 0.0});
      for (int k = 0; k < 4; ++k) reference.add({}, std::span(&point, 1));
    }
    EXPECT_EQ(reference.freeSpaceViolation({}, image, 4.0), share) << count;
    EXPECT_EQ(reference.freeSpaceViolation({}, image, 5.0), 0.0) << "none was met so often";
  }
}

long pageFaults() {
  rusage usage{};
  getrusage(RUSAGE_THREAD, &usage);
  return usage.ru_minflt;
}

TEST(Reference, WaitsForNoPageAfterItTookItsMemory) {
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
  GTEST_SKIP() << "the sanitizers take pages of their own";
#endif
  Reference reference;
  const ScanPoint before = wallPoint(1.0, 1.0, {0.0, 1.0});
  reference.add({}, std::span(&before, 1));
  reference.takeMemory();
  EXPECT_EQ(reference.size(), 1);
  EXPECT_NE(reference.nearest({1.0, 1.0}, 0.1), nullptr);
  ScanPoints points;
  for (int i = -150; i <= 150; ++i) points.push_back(wallPoint(0.1 * i, 0.07 * i, {0.0, 1.0}));
  Reference other;  // takes the pages of the program, which is not the reference's
  other.add({}, points);
  const long first = pageFaults();
  EXPECT_EQ(reference.add({}, points), 301);
  EXPECT_EQ(pageFaults(), first);
}

}  // namespace
}  // namespace slam::reference_test
