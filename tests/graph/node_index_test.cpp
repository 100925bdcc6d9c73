// SPDX-License-Identifier: BSD-3-Clause
#include "graph/node_index.hpp"

#include <algorithm>
#include <gmock/gmock.h>
#include <limits>
#include <random>

namespace slam::node_index_test {
namespace {

using testing::ElementsAre;
using testing::IsSupersetOf;

std::vector<int> within(const std::vector<Eigen::Vector2d>& places, const Eigen::Vector2d& p, double radius) {
  std::vector<int> nodes;
  for (int i = 0; i < std::ssize(places); ++i) {
    if ((places[static_cast<std::size_t>(i)] - p).norm() < radius) nodes.push_back(i);
  }
  return nodes;
}

TEST(NodeIndex, FindsAllNodesWithinARadiusWhereverTheyHaveMoved) {
  std::mt19937 random(1);
  std::uniform_real_distribution<double> metres(-100.0, 100.0);
  const auto draw = [&] { return Eigen::Vector2d(metres(random), metres(random)); };
  NodeIndex index;
  std::vector<Eigen::Vector2d> places;
  for (int i = 0; i < 400; ++i) {
    places.push_back(draw());
    index.add(places.back());
  }
  for (int i = 0; i < 400; i += 3) {
    places[static_cast<std::size_t>(i)] = draw();
    index.move(i, places[static_cast<std::size_t>(i)]);
  }
  places.resize(350);
  index.truncate(350);
  for (const double radius : {0.5, 8.0, 20.0, 1e4}) {
    const Eigen::Vector2d p = draw();
    std::vector<int> found = index.candidates(p, radius);
    EXPECT_THAT(found, IsSupersetOf(within(places, p, radius))) << radius;
    std::sort(found.begin(), found.end());
    EXPECT_EQ(std::adjacent_find(found.begin(), found.end()), found.end()) << "each once";
  }
  EXPECT_LT(index.candidates({0.0, 0.0}, 0.5).size(), 20U) << "and few beyond";
}

TEST(NodeIndex, KeepsPlacesThatAreNoNumbers) {
  NodeIndex index;
  index.add({1.0, 1.0});
  for (const double bad : {std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity(), -1e300}) {
    index.move(0, {bad, bad});
  }
  EXPECT_THAT(index.candidates({0.0, 0.0}, 1e300), ElementsAre(0));
  index.move(0, {1.0, 1.0});
  EXPECT_THAT(index.candidates({0.0, 0.0}, 2.0), ElementsAre(0));
}

}  // namespace
}  // namespace slam::node_index_test
