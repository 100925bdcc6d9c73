// SPDX-License-Identifier: BSD-3-Clause
#include "tools/eval/map_metrics.hpp"

#include <cmath>
#include <gtest/gtest.h>
#include <numbers>
#include <string>

namespace slam::map_metrics_test {
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

TEST(CompareMaps, MeasuresHowMuchOfTheMapIsMapped) {
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

TEST(CompareMaps, CountsObstaclesInOpenSpaceAlone) {
  const MapImage truth = image({"........", "........", "........", "......##"});
  // Four of its 30 free cells touch the obstacle. The map errs there, too, and in two of the others.
  const MapErrors errors = compareMaps(image({"#.......", "........", "#....###", ".....###"}), truth);
  EXPECT_DOUBLE_EQ(errors.false_obstacles, 2.0 / 26.0);
  EXPECT_DOUBLE_EQ(compareMaps(truth, truth).false_obstacles, 0.0);
}

TEST(CompareMaps, ForgivesOneCellInEachDirectionAndCorner) {
  for (const auto& [row, column] : {std::pair(0, 0), {0, 2}, {1, 3}, {2, 0}, {3, 3}, {3, 1}}) {
    MapImage map = image({"....", "....", "....", "...."}), truth = map;
    truth.at(column == 0 ? 1 : column == 3 ? 2 : column, row == 0 ? 1 : row == 3 ? 2 : row) = MapImage::kOccupied;
    map.at(column, row) = MapImage::kOccupied;
    EXPECT_DOUBLE_EQ(compareMaps(map, truth).occupied.f1, 1.0) << column << ' ' << row;
  }
}

TEST(CompareMaps, ForgivesACellOfTheCoarserOne) {
  const std::string row = "..........#...................";
  const MapImage map = image({row, row, row});  // the truth's wall are the map's cells 6 to 8
  MapImage truth = image({"..#......."});
  truth.resolution = 3.0 * map.resolution;
  const MapErrors errors = compareMaps(map, truth);
  EXPECT_DOUBLE_EQ(errors.occupied.precision, 1.0);
  EXPECT_DOUBLE_EQ(errors.occupied.recall, 1.0);
}

TEST(CompareMaps, TakesNothingFromBeyondItsRim) {
  const MapImage truth = image({"........", "........", "........"});
  MapImage map = image({"####", "####", "####"});
  map.origin_x = 4.2 * map.resolution;  // half a cell left of and below its first one there is nothing
  map.origin_y = 1.1 * map.resolution;
  EXPECT_DOUBLE_EQ(compareMaps(map, truth).completeness, 4.0 * 2.0 / 24.0);
}

TEST(CompareMaps, AFreeCellIsRightWhereTheTruthIsFree) {
  const MapErrors errors = compareMaps(image({"....??"}), image({"..#??."}));
  EXPECT_DOUBLE_EQ(errors.free.precision, 2.0 / 3.0) << "one of four lies where nobody knows";
  EXPECT_DOUBLE_EQ(errors.free.recall, 2.0 / 3.0);
  EXPECT_DOUBLE_EQ(errors.completeness, 3.0 / 4.0);
}

}  // namespace
}  // namespace slam::map_metrics_test
