// SPDX-License-Identifier: BSD-3-Clause
#include "graph/keyframe_graph.hpp"

#include <Eigen/LU>
#include <cmath>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <memory>
#include <numbers>
#include <vector>

#include "support/simulated/keyframes.hpp"

namespace slam::keyframe_graph_test {
namespace {

using test::KeyframeDrive;

const Eigen::Vector3d kSigma(0.01, 0.02, 0.003);

double distance(const Pose2& a, const Pose2& b) { return std::hypot(a.x - b.x, a.y - b.y); }

TEST(KeyframeGraph, JoinsEachKeyframeToItsPredecessor) {
  KeyframeDrive drive(test::furnishedRoom());
  KeyframeGraph keyframes;
  for (int i = 0; i < 4; ++i) {
    keyframes.add(drive.at({-1.5 + 0.4 * i, -0.8, 0.1 * i}, kSigma));
    ASSERT_EQ(keyframes.size(), i + 1);
    ASSERT_LT(distance(keyframes.pose(i), drive.measured.back()), 1e-12);
  }
  ASSERT_EQ(keyframes.graph().edges().size(), 3U);
  for (int i = 0; i < 3; ++i) {
    const Edge& edge = keyframes.graph().edges()[static_cast<std::size_t>(i)];
    EXPECT_EQ(edge.from, i);
    EXPECT_EQ(edge.to, i + 1);
    EXPECT_EQ(edge.kind, EdgeKind::kMotion);
    EXPECT_NEAR(chiSquare(edge, keyframes.pose(i), keyframes.pose(i + 1)), 0.0, 1e-12);
  }
}

TEST(KeyframeGraph, AStepErrsInThePredecessorsAxesAsTheFrontEndClaims) {
  for (const double turn : {0.0, 0.5, std::numbers::pi / 2, -2.0}) {
    KeyframeDrive drive(test::furnishedRoom());
    KeyframeGraph keyframes;
    keyframes.add(drive.at({-1.5, -0.8, 0.3}, kSigma));
    keyframes.add(drive.at({-1.1, -0.8, 0.3 + turn}, kSigma));
    const Edge& edge = keyframes.graph().edges()[0];
    const Pose2 step = edge.T_from_to;
    EXPECT_NEAR(chiSquare(edge, {}, {step.x + kSigma.x(), step.y, step.theta}), 1.0, 1e-9) << turn;
    EXPECT_NEAR(chiSquare(edge, {}, {step.x, step.y + kSigma.y(), step.theta}), 1.0, 1e-9) << turn;
    EXPECT_NEAR(chiSquare(edge, {}, {step.x, step.y, step.theta + kSigma.z()}), 1.0, 1e-9) << turn;
  }
}

TEST(KeyframeGraph, TheFirstKeyframeLiesWhereTheFrontEndPutIt) {
  auto keyframe = std::make_unique<Keyframe>();
  keyframe->T_map_base = {1.0, 2.0, 3.0};
  keyframe->T_previous_base = {9.0, 9.0, 9.0};  // there is no keyframe before it
  KeyframeGraph keyframes;
  keyframes.add(*keyframe);
  EXPECT_EQ(keyframes.pose(0), keyframe->T_map_base);
  EXPECT_TRUE(keyframes.graph().edges().empty());
}

TEST(KeyframeGraph, ANewKeyframeGoesOnFromItsPredecessorsCorrectedPose) {
  KeyframeDrive drive(test::furnishedRoom());
  KeyframeGraph keyframes;
  keyframes.add(drive.at({-1.5, -0.8, 0.0}, kSigma));
  keyframes.add(drive.at({-1.1, -0.8, 0.0}, kSigma));
  const Pose2 corrected{5.0, 1.0, 2.0};
  keyframes.graph().setPose(1, corrected);
  const Keyframe& next = drive.at({-0.7, -0.8, 0.0}, kSigma);
  keyframes.add(next);
  EXPECT_EQ(keyframes.pose(2), corrected * next.T_previous_base);
}

TEST(KeyframeGraph, AStoredKeyframeHasNoEdge) {
  KeyframeGraph keyframes;
  const auto scan = std::make_shared<const StoredScan>();
  keyframes.add(scan, {1.0, 2.0, 0.5});
  keyframes.add(scan, {3.0, 2.0, 0.5});
  EXPECT_EQ(keyframes.size(), 2);
  EXPECT_EQ(keyframes.pose(1), (Pose2{3.0, 2.0, 0.5}));
  EXPECT_EQ(keyframes.scan(1), scan);
  EXPECT_TRUE(keyframes.graph().edges().empty());
}

TEST(KeyframeGraph, FindsTheKeyframesNearAPlace) {
  KeyframeGraph keyframes;
  for (const double x : {0.0, 1.0, 5.0, -1.9, 2.1}) keyframes.add(std::make_shared<const StoredScan>(), {x, 0.0, x});
  EXPECT_THAT(keyframes.near({0.0, 0.0}, 2.0), testing::ElementsAre(0, 1, 3));
  EXPECT_THAT(keyframes.near({5.0, 1.0}, 1.5), testing::ElementsAre(2));
  EXPECT_THAT(keyframes.near({50.0, 0.0}, 1.5), testing::IsEmpty());
  keyframes.graph().setPose(2, {0.0, 1.0, 0.0});
  EXPECT_THAT(keyframes.near({0.0, 0.0}, 2.0), testing::ElementsAre(0, 1, 2, 3));
}

TEST(KeyframeGraph, GivesPointsBackAsTheyWereScannedButForQuantisation) {
  const test::Place room = test::furnishedRoom();
  std::mt19937 random(1);
  ScanPoints scanned = room.scan({-1.5, -0.8, 0.4}, 0.01, random);
  std::size_t every = 0;
  for (ScanPoint& point : scanned) point.grazing = !point.hasNormal() && ++every % 2 == 0;
  auto keyframe = std::make_unique<Keyframe>();
  for (const ScanPoint& point : scanned)
    keyframe->storage[static_cast<std::size_t>(keyframe->size++)] = keyframePoint(point);
  KeyframeGraph keyframes;
  keyframes.add(*keyframe);

  ScanPoints points(7);  // what is in there goes
  keyframes.points(0, points);
  ASSERT_EQ(points.size(), scanned.size());
  int lines = 0;
  for (std::size_t i = 0; i < points.size(); ++i) {
    ASSERT_LT((points[i].position - scanned[i].position).norm(), 1e-6);
    ASSERT_NEAR(points[i].range, scanned[i].position.norm(), 1e-6);
    ASSERT_EQ(points[i].hasNormal(), scanned[i].hasNormal());
    ASSERT_EQ(points[i].grazing, scanned[i].grazing);
    if (!scanned[i].hasNormal()) continue;
    ++lines;
    ASSERT_LT((points[i].normal - scanned[i].normal).norm(), Keyframe::Point::kAngle);
    ASSERT_NEAR(std::sqrt(points[i].normal_variance), std::sqrt(scanned[i].normal_variance), Keyframe::Point::kAngle);
  }
  EXPECT_GT(lines, 200);
  EXPECT_LT(lines, static_cast<int>(points.size()));
}

TEST(KeyframeGraph, MeasuresRangesFromTheLidar) {
  auto keyframe = std::make_unique<Keyframe>();
  keyframe->T_base_lidar = {1.0, 0.5, 2.0};
  keyframe->storage[0] = {4.0F, 4.5F};
  keyframe->size = 1;
  KeyframeGraph keyframes;
  keyframes.add(*keyframe);
  ScanPoints points;
  keyframes.points(0, points);
  ASSERT_EQ(points.size(), 1U);
  EXPECT_DOUBLE_EQ(points[0].range, 5.0);
  EXPECT_FALSE(points[0].hasNormal());
}

TEST(KeyframeGraph, PutsKeyframesIntoAReferenceAtTheirPoses) {
  KeyframeGraph keyframes;
  auto scan = std::make_shared<StoredScan>();
  scan->points.push_back({.x = 2.0F, .y = 0.0F});
  const double quarter = std::numbers::pi / 2;
  keyframes.add(scan, {0.0, 0.0, 0.0});
  keyframes.add(scan, {1.0, 1.0, quarter});
  keyframes.add(scan, {-5.0, 0.0, 0.0});
  Reference reference;
  keyframes.addTo(reference, std::vector{0, 1});
  EXPECT_EQ(reference.size(), 2);
  EXPECT_NE(reference.nearest({2.0, 0.0}, 0.1), nullptr);
  EXPECT_NE(reference.nearest({1.0, 3.0}, 0.1), nullptr);
  EXPECT_EQ(reference.nearest({-3.0, 0.0}, 0.1), nullptr);
}

TEST(KeyframeGraph, AScanLosesThePointsThatLieOnTheRobot) {
  Keyframe keyframe;
  keyframe.T_base_lidar = {0.1, 0.0, std::numbers::pi / 2};
  const auto see = [&](double x, double y) {  // [m] in lidar
    const Eigen::Vector2d p = keyframe.T_base_lidar * Eigen::Vector2d(x, y);
    keyframe.storage[static_cast<std::size_t>(keyframe.size++)] = {.x = static_cast<float>(p.x()),
                                                                   .y = static_cast<float>(p.y())};
  };
  see(-0.3, 0.0);
  see(2.0, 1.0);
  see(-0.3, 0.05);
  see(-0.5, 0.0);
  KeyframeGraph keyframes;
  keyframes.add(keyframe);
  BodyShape behind;
  behind.millimetres[179] = behind.millimetres[180] = 300;
  const auto rest = scanWithout(keyframes.scan(0), behind, 0.1);
  ASSERT_EQ(rest->points.size(), 2U);
  EXPECT_EQ(rest->points[0].x, keyframe.storage[1].x);
  EXPECT_EQ(rest->points[1].x, keyframe.storage[3].x);
  EXPECT_EQ(rest->T_base_lidar, keyframe.T_base_lidar);
  EXPECT_EQ(keyframes.scan(0)->points.size(), 4U) << "whoever holds the old one keeps it";
  keyframes.setScan(0, rest);
  EXPECT_EQ(scanWithout(keyframes.scan(0), behind, 0.1), rest) << "the same one";
}

}  // namespace
}  // namespace slam::keyframe_graph_test
