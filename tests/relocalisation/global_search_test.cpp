// SPDX-License-Identifier: BSD-3-Clause
#include "relocalisation/global_search.hpp"

#include <cmath>
#include <gtest/gtest.h>
#include <random>

namespace slam::test::global_search_test {
namespace {

using Points = std::vector<Eigen::Vector2d>;

Points randomWalls(std::mt19937& random) {
  std::uniform_real_distribution<double> x(0.0, 8.0), y(0.0, 6.0), step(-0.1, 0.1);
  Points walls;
  for (double s = 0.0; s <= 8.0; s += 0.2) {  // a room 8 m by 6 m, with furniture anyhow
    walls.insert(walls.end(), {{s, 0.0}, {s, 6.0}, {0.0, 0.75 * s}, {8.0, 0.75 * s}});
  }
  for (int line = 0; line < 6; ++line) {
    Eigen::Vector2d p(x(random), y(random));
    const Eigen::Vector2d along(step(random), step(random));
    for (int i = 0; i < 20; ++i, p += along) walls.push_back(p);
  }
  return walls;
}

Points seenFrom(const Points& walls, const Pose2& T_map_query, double noise, std::mt19937& random) {
  std::normal_distribution<double> error(0.0, noise);
  Points query;
  for (const Eigen::Vector2d& p : walls) {
    query.push_back(T_map_query.inverse() * p + Eigen::Vector2d(error(random), error(random)));
  }
  return query;
}

TEST(GlobalSearch, BranchAndBoundEqualsExhaustiveSearch) {
  for (unsigned seed = 1; seed <= 10; ++seed) {
    std::mt19937 random(seed);
    const Points walls = randomWalls(random), strangers = randomWalls(random);
    Points query = seenFrom(walls, {3.0, 2.5, 0.7 * seed}, 0.05, random);
    for (std::size_t i = 0; i < query.size(); i += 2) query[i] = strangers[i];  // half of it is not in the map
    GlobalSearchConfig flat;
    flat.levels = 1;  // nothing to branch: every pose is scored
    const auto pyramid = GlobalSearch(walls).search(query, 0.1, 1, 1.0);
    const auto exhaustive = GlobalSearch(walls, flat).search(query, 0.1, 1, 1.0);
    ASSERT_EQ(pyramid.size(), 1u);
    ASSERT_EQ(exhaustive.size(), 1u);
    EXPECT_DOUBLE_EQ(pyramid[0].score, exhaustive[0].score) << "seed " << seed;
  }
}

TEST(GlobalSearch, FindsAPlaceFromAnywhere) {
  std::mt19937 random(7);
  const Points walls = randomWalls(random);
  for (int i = 0; i < 12; ++i) {
    const Pose2 truth{1.0 + 0.5 * i, 1.0 + 0.3 * i, wrapAngle(0.55 * i)};
    const auto places = GlobalSearch(walls).search(seenFrom(walls, truth, 0.02, random), 0.3, 5, 0.8);
    ASSERT_FALSE(places.empty());
    const Pose2 error = between(truth, places[0].T_map_query);
    EXPECT_LT(std::hypot(error.x, error.y), 0.2);
    EXPECT_LT(std::abs(error.theta), 0.1);
  }
}

TEST(GlobalSearch, InAWindowItFindsWhatAnExhaustiveSearchFindsThere) {
  for (unsigned seed = 1; seed <= 10; ++seed) {
    std::mt19937 random(seed);
    const Points walls = randomWalls(random);
    const Pose2 truth{3.0, 2.5, wrapAngle(0.7 * seed)};
    const Points query = seenFrom(walls, truth, 0.05, random);
    GlobalSearchConfig flat;
    flat.levels = 1;
    for (const Pose2& off : {Pose2{0.4, -0.3, 0.1}, Pose2{2.0, 1.0, 0.5}, Pose2{-1.5, 0.0, 3.1}}) {
      const PlaceWindow window{truth * off, 0.9, 0.3};
      const auto pyramid = GlobalSearch(walls).search(query, 0.01, 1, 1.0, window);
      const auto exhaustive = GlobalSearch(walls, flat).search(query, 0.01, 1, 1.0, window);
      ASSERT_EQ(pyramid.size(), 1U);
      ASSERT_EQ(exhaustive.size(), 1U);
      EXPECT_TRUE(window.holds(pyramid[0].T_map_query)) << "seed " << seed;
      EXPECT_DOUBLE_EQ(pyramid[0].score, exhaustive[0].score) << "seed " << seed;
    }
    EXPECT_TRUE(GlobalSearch(walls).search(query, 0.01, 5, 0.1, PlaceWindow{{50.0, 0.0, 0.0}, 1.0, 0.3}).empty());
  }
}

TEST(GlobalSearch, GivesPlacesBestFirstAndApart) {
  std::mt19937 random(3);
  const Points walls = randomWalls(random);
  const GlobalSearchConfig config;
  const auto places = GlobalSearch(walls, config).search(seenFrom(walls, {4.0, 3.0, 1.0}, 0.05, random), 0.1, 20, 0.2);
  ASSERT_GT(places.size(), 3u);
  for (std::size_t i = 1; i < places.size(); ++i) {
    EXPECT_LE(places[i].score, places[i - 1].score);
    for (std::size_t j = 0; j < i; ++j) {
      const Pose2 gap = between(places[i].T_map_query, places[j].T_map_query);
      EXPECT_TRUE(std::hypot(gap.x, gap.y) > config.distinct_distance ||
                  std::abs(gap.theta) > config.distinct_rotation);
    }
  }
}

TEST(GlobalSearch, InSmallStepsItComesToTheSameEnd) {
  std::mt19937 random(5);
  const Points walls = randomWalls(random);
  const Points query = seenFrom(walls, {4.0, 3.0, 1.0}, 0.05, random);
  const GlobalSearch global(walls);
  constexpr std::int64_t kStep = 20000, kOvershoot = 2000;  // [points]
  auto search = global.begin(query, 0.1, 20, 0.2);
  std::int64_t all = 0;
  int steps = 0;
  for (; !search.done(); ++steps) {
    ASSERT_LT(steps, 10000);
    std::int64_t work = kStep;
    global.goOn(search, work);
    EXPECT_TRUE(search.done() || work <= 0);
    EXPECT_GE(work, -kOvershoot);
    all += kStep - work;
  }
  EXPECT_TRUE(search.complete());
  EXPECT_GT(steps, 5);
  std::int64_t at_once = 1'000'000'000;
  auto whole = global.begin(query, 0.1, 20, 0.2);
  global.goOn(whole, at_once);
  EXPECT_EQ(all, 1'000'000'000 - at_once);
  ASSERT_EQ(search.places().size(), whole.places().size());
  for (std::size_t i = 0; i < whole.places().size(); ++i) {
    EXPECT_EQ(search.places()[i].score, whole.places()[i].score);
    EXPECT_EQ(search.places()[i].T_map_query.x, whole.places()[i].T_map_query.x);
    EXPECT_EQ(search.places()[i].T_map_query.theta, whole.places()[i].T_map_query.theta);
  }
}

TEST(GlobalSearch, ReportsWhetherPlacesMayBeMissingForWantOfRoom) {
  std::mt19937 random(6);
  const Points walls = randomWalls(random);
  const Points query = seenFrom(walls, {4.0, 3.0, 1.0}, 0.05, random);
  for (const std::size_t room : {std::size_t{100}, GlobalSearchConfig{}.max_open}) {
    GlobalSearchConfig config;
    config.max_open = room;
    const GlobalSearch global(walls, config);
    auto search = global.begin(query, 0.1, 20, 0.2);
    std::int64_t work = 1'000'000'000;
    global.goOn(search, work);
    EXPECT_TRUE(search.done());
    EXPECT_EQ(search.complete(), room > 100);
    ASSERT_FALSE(search.places().empty()) << "the best blocks are kept";
    EXPECT_LT((search.places()[0].T_map_query.translation() - Eigen::Vector2d(4.0, 3.0)).norm(), 0.2);
  }
}

TEST(GlobalSearch, TakesAnotherHeadingForAnotherPlace) {
  std::mt19937 random(4);
  Points walls;  // a square room, which looks the same in four directions
  for (double s = 0.0; s < 6.0; s += 0.2)
    walls.insert(walls.end(), {{s, 0.0}, {6.0, s}, {6.0 - s, 6.0}, {0.0, 6.0 - s}});
  const auto places = GlobalSearch(walls).search(seenFrom(walls, {3.0, 3.0, 0.0}, 0.02, random), 0.5, 4, 0.9);
  ASSERT_EQ(places.size(), 4u);
  for (std::size_t i = 0; i < places.size(); ++i) {
    const Pose2& place = places[i].T_map_query;
    EXPECT_LT((place.translation() - Eigen::Vector2d(3.0, 3.0)).norm(), 0.3);
    for (std::size_t j = 0; j < i; ++j) EXPECT_GT(std::abs(wrapAngle(place.theta - places[j].T_map_query.theta)), 1.3);
  }
}

}  // namespace
}  // namespace slam::test::global_search_test
