// SPDX-License-Identifier: BSD-3-Clause
#include "tools/eval/map_metrics.hpp"

#include <cmath>
#include <gtest/gtest.h>
#include <numbers>
#include <string>

namespace slam {
namespace {

/// '#' occupied, '.' free, '?' unknown; rows from the top.
MapImage image(const std::vector<std::string>& rows) {
  MapImage map;
  map.width = static_cast<int>(rows.front().size());
  map.height = static_cast<int>(rows.size());
  for (const std::string& row : rows) {
    for (const char c : row) {
      map.cells.push_back(c == '#' ? MapImage::kOccupied : c == '.' ? MapImage::kFree : MapImage::kUnknown);
    }
  }
  return map;
}

const std::vector<std::string> kRoom = {"########", "#......#", "#......#", "#......#",
                                        "#....###", "#....#??", "######??"};

TEST(CompareMaps, FindsAMapEqualToItself) {
  const MapErrors errors = compareMaps(image(kRoom), image(kRoom));
  EXPECT_EQ(errors.compared, 52);
  EXPECT_DOUBLE_EQ(errors.completeness, 1.0);
  for (const PrecisionRecall& score : {errors.occupied, errors.free}) {
    EXPECT_DOUBLE_EQ(score.precision, 1.0);
    EXPECT_DOUBLE_EQ(score.recall, 1.0);
    EXPECT_DOUBLE_EQ(score.f1, 1.0);
  }
}

TEST(CompareMaps, ForgivesWallsOneCellAside) {
  const MapErrors errors = compareMaps(image({"...#......"}), image({"..#......."}));
  EXPECT_DOUBLE_EQ(errors.occupied.precision, 1.0);
  EXPECT_DOUBLE_EQ(errors.occupied.recall, 1.0);
  const MapErrors two = compareMaps(image({"....#....."}), image({"..#......."}));
  EXPECT_DOUBLE_EQ(two.occupied.precision, 0.0);
  EXPECT_DOUBLE_EQ(two.occupied.recall, 0.0);
  EXPECT_DOUBLE_EQ(two.occupied.f1, 0.0);
}

TEST(CompareMaps, CountsAWallThatIsNotThere) {
  const MapErrors errors = compareMaps(image({"#....#...."}), image({"#........."}));
  EXPECT_DOUBLE_EQ(errors.occupied.precision, 0.5);
  EXPECT_DOUBLE_EQ(errors.occupied.recall, 1.0);
  EXPECT_DOUBLE_EQ(errors.occupied.f1, 2.0 / 3.0);
  EXPECT_DOUBLE_EQ(errors.free.precision, 1.0);
  EXPECT_DOUBLE_EQ(errors.free.recall, 8.0 / 9.0);
}

TEST(CompareMaps, LooksOnlyWhereTheTruthIsKnown) {
  const MapErrors errors = compareMaps(image({"#....#####"}), image({"#....?????"}));
  EXPECT_EQ(errors.compared, 5);
  EXPECT_DOUBLE_EQ(errors.occupied.precision, 1.0);
  EXPECT_DOUBLE_EQ(errors.completeness, 1.0);
}

TEST(CompareMaps, MeasuresHowMuchTheMapKnows) {
  EXPECT_DOUBLE_EQ(compareMaps(image({"#....?????"}), image({"#........."})).completeness, 0.5);
  const MapErrors nothing = compareMaps(image({"?"}), image({"#........."}));
  EXPECT_DOUBLE_EQ(nothing.completeness, 0.0);
  EXPECT_DOUBLE_EQ(nothing.occupied.recall, 0.0);
  EXPECT_DOUBLE_EQ(nothing.occupied.f1, 0.0);
  const MapErrors no_truth = compareMaps(image({"#..."}), image({"????"}));
  EXPECT_EQ(no_truth.compared, 0);
  EXPECT_TRUE(std::isfinite(no_truth.completeness) && std::isfinite(no_truth.free.f1));
}

TEST(CompareMaps, PlacesTheMapInTheFrameOfTheTruth) {
  MapImage truth = image(kRoom);
  truth.origin_x = -1.0;
  truth.origin_y = 2.0;
  // The same room a quarter turn clockwise: the truth's columns from the right are its rows from the top, reversed.
  MapImage turned = image(std::vector<std::string>(kRoom.front().size(), std::string(kRoom.size(), '?')));
  for (int row = 0; row < truth.height; ++row) {
    for (int column = 0; column < truth.width; ++column) {
      turned.at(row, truth.width - 1 - column) = truth.at(column, row);
    }
  }
  // p_truth = R(90 deg) p_map + t with p_map = (row, width - column) cells: x = -(width - column) + t_x, y = row + t_y.
  const Pose2 T_truth_map{truth.width * truth.resolution + truth.origin_x, truth.origin_y, std::numbers::pi / 2};
  const MapErrors errors = compareMaps(turned, truth, T_truth_map);
  EXPECT_DOUBLE_EQ(errors.completeness, 1.0);
  EXPECT_DOUBLE_EQ(errors.free.f1, 1.0);
  EXPECT_DOUBLE_EQ(errors.occupied.f1, 1.0);
}

}  // namespace
}  // namespace slam
