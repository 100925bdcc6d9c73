// SPDX-License-Identifier: BSD-3-Clause
#include "relocalisation/distance_field.hpp"

#include <cmath>
#include <gtest/gtest.h>
#include <memory>
#include <numbers>
#include <vector>

namespace slam::distance_field_test {
namespace {

using Known = DistanceField::Known;

constexpr double kQuarter = std::numbers::pi / 2;

Keyframe::Point onWall(double x, double y, double normal) {
  return {.x = static_cast<float>(x),
          .y = static_cast<float>(y),
          .normal = static_cast<std::int16_t>(std::lround(normal / Keyframe::Point::kAngle))};
}

/// A wall 4 m ahead of the base, 3 m long, seen by a lidar beside it.
std::shared_ptr<StoredScan> aheadOf(const Pose2& T_base_lidar) {
  auto scan = std::make_shared<StoredScan>();
  scan->T_base_lidar = T_base_lidar;
  for (int i = -30; i <= 30; ++i) scan->points.push_back(onWall(4.0, 0.05 * i, std::numbers::pi));
  return scan;
}

Known at(const DistanceField& field, const Eigen::Vector2d& p) {
  const auto i = field.index(p);
  return i < 0 ? Known::kNothing : field.known(static_cast<std::size_t>(i));
}

TEST(DistanceField, ShowsWallsAndWhatBeamsPassedWhereTheKeyframeLies) {
  for (const Pose2& T_map_base : {Pose2{}, Pose2{2.0, -1.0, kQuarter}, Pose2{-3.0, 0.5, 2.1}}) {
    KeyframeGraph keyframes;
    keyframes.add(aheadOf({0.5, 1.0, 0.3}), T_map_base);
    const DistanceField field(keyframes, std::vector{0});
    const auto known = [&](double x, double y) { return at(field, T_map_base * Eigen::Vector2d(x, y)); };
    EXPECT_EQ(known(4.0, 0.5), Known::kSolid);
    EXPECT_EQ(known(2.5, 1.1), Known::kFree) << "beams begin at the lidar";
    EXPECT_EQ(known(2.5, -0.8), Known::kNothing) << "and not at the base";
    EXPECT_EQ(known(3.5, 0.5), Known::kFree);
    EXPECT_EQ(known(3.87, 0.5), Known::kNothing) << "near its end a beam shows nothing";
    EXPECT_EQ(known(4.3, 0.5), Known::kNothing) << "behind the wall";

    const Eigen::Vector2d before = T_map_base * Eigen::Vector2d(3.0, 0.5);
    const DistanceField::Wall* wall = field.nearest(before);
    ASSERT_NE(wall, nullptr);
    EXPECT_LT((wall->position - T_map_base * Eigen::Vector2d(4.0, 0.5)).norm(), 0.11);
    EXPECT_LT((wall->normal - PointTransform(T_map_base).turned({-1.0, 0.0})).norm(), 1e-3) << "towards free space";
    EXPECT_EQ(field.nearest(T_map_base * Eigen::Vector2d(1.8, 0.0)), nullptr) << "2 m are not reached";
    EXPECT_NE(field.nearest(T_map_base * Eigen::Vector2d(2.2, 0.0)), nullptr);
  }
}

TEST(DistanceField, EachSettingHasItsEffect) {
  KeyframeGraph keyframes;
  keyframes.add(aheadOf({}), {});
  const std::vector<int> map{0};
  const DistanceField usual(keyframes, map);
  EXPECT_NEAR(usual.columns() * usual.cell(), 4.0 + 0.1, 0.2) << "reach to both sides";
  EXPECT_NEAR(usual.rows() * usual.cell(), 3.0 + 4.0 + 0.1, 0.2);
  const DistanceField wider(keyframes, map, {.margin = 1.5});
  EXPECT_NEAR((wider.columns() - usual.columns()) * usual.cell(), 3.0, 1e-9);
  EXPECT_NEAR((wider.rows() - usual.rows()) * usual.cell(), 3.0, 1e-9);
  const DistanceField near(keyframes, map, {.reach = 1.0});
  EXPECT_EQ(near.nearest({2.8, 0.0}), nullptr);
  EXPECT_NE(near.nearest({3.2, 0.0}), nullptr);
  const DistanceField fine(keyframes, map, {.cell = 0.05});
  EXPECT_EQ(fine.cell(), 0.05);
  const DistanceField coarse(keyframes, map, {.max_cells = 400});
  EXPECT_NEAR(coarse.cell(), std::sqrt(4.0 * 7.0 / 400), 1e-9);
  const DistanceField bold(keyframes, map, {.before_end = 0.6});
  EXPECT_EQ(at(bold, {3.3, 0.0}), Known::kFree);
  EXPECT_EQ(at(bold, {3.55, 0.0}), Known::kNothing);
  EXPECT_EQ(at(usual, {3.55, 0.0}), Known::kFree);
}

TEST(DistanceField, AWallIsAsThickAsItIsDrawn) {
  for (const int layers : {1, 2, 4}) {
    KeyframeGraph keyframes;
    auto scan = std::make_shared<StoredScan>();
    for (int layer = 0; layer < layers; ++layer) {
      for (int i = 0; i < 100; ++i) scan->points.push_back(onWall(1.0 + 0.1 * layer, 0.1 * i, 0.0));
    }
    keyframes.add(scan, {});
    const DistanceField field(keyframes, std::vector{0});
    EXPECT_NEAR(field.thickness(), 0.1 * layers, 0.01 * layers) << layers;
  }
}

TEST(DistanceField, AFloorPlanItselfGivesWhatIsFreeAndSolid) {
  KeyframeGraph keyframes;
  auto scan = std::make_shared<StoredScan>();
  scan->points.push_back(onWall(1.0, 0.0, std::numbers::pi));
  scan->free.emplace_back(0.5F, 0.0F);
  scan->solid.emplace_back(1.2F, 0.3F);
  const Pose2 T_map_scan{1.0, 2.0, kQuarter};
  keyframes.add(scan, T_map_scan);
  const DistanceField field(keyframes, std::vector{0}, {.kind = MapKind::kFloorPlan});
  EXPECT_EQ(at(field, T_map_scan * Eigen::Vector2d(0.5, 0.0)), Known::kFree);
  EXPECT_EQ(at(field, T_map_scan * Eigen::Vector2d(1.2, 0.3)), Known::kSolid);
  EXPECT_EQ(at(field, T_map_scan * Eigen::Vector2d(1.0, 0.0)), Known::kSolid);
  EXPECT_EQ(at(field, T_map_scan * Eigen::Vector2d(0.2, 0.0)), Known::kNothing) << "it was seen from nowhere";
  const DistanceField scans(keyframes, std::vector{0});
  EXPECT_EQ(at(scans, T_map_scan * Eigen::Vector2d(0.2, 0.0)), Known::kFree)
      << "what no plan holds was seen by a lidar";
  std::vector<Eigen::Vector2d> points;
  forEachWallPoint(keyframes, std::vector{0}, [&](const Eigen::Vector2d& p) { points.push_back(p); });
  ASSERT_EQ(points.size(), 2U);
  EXPECT_LT((points[0] - T_map_scan * Eigen::Vector2d(1.2, 0.3)).norm(), 1e-6);
  EXPECT_LT((points[1] - T_map_scan * Eigen::Vector2d(1.0, 0.0)).norm(), 1e-6);
}

TEST(DistanceField, OutsideNothingIsKnown) {
  KeyframeGraph keyframes;
  keyframes.add(aheadOf({}), {});
  const DistanceField field(keyframes, std::vector{0});
  EXPECT_EQ(field.index({4.0, 30.0}), -1);
  EXPECT_EQ(field.index({-30.0, 0.0}), -1);
  EXPECT_EQ(field.nearest({40.0, 0.0}), nullptr);
  EXPECT_EQ(field.known(-1, 3), Known::kNothing);
  EXPECT_EQ(field.known(3, -1), Known::kNothing);
  EXPECT_EQ(field.known(field.columns(), 3), Known::kNothing);
  EXPECT_EQ(field.known(3, field.rows()), Known::kNothing);
  const DistanceField empty(keyframes, {});
  EXPECT_EQ(empty.thickness(), 0.0);
  EXPECT_EQ(empty.index({0.0, 0.0}), -1);
  EXPECT_EQ(empty.nearest({0.0, 0.0}), nullptr);
}

}  // namespace
}  // namespace slam::distance_field_test
