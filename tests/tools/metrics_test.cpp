// SPDX-License-Identifier: BSD-3-Clause
#include "tools/eval/metrics.hpp"

#include <cmath>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <numbers>
#include <random>

#include "tools/files.hpp"

namespace slam::metrics_test {
namespace {

using test::Folder;
using test::refusalOf;
using testing::HasSubstr;

constexpr double kDegree = std::numbers::pi / 180.0;

Timestamp at(double seconds) { return Timestamp(fromSeconds(seconds)); }

Trajectory wanderingPath() {
  std::mt19937 random(1);
  std::normal_distribution<double> normal;
  Trajectory rows;
  Pose2 pose;
  for (int i = 0; i < 200; ++i) {
    rows.push_back({at(0.1 * i), pose});
    pose = pose * Pose2{0.1, 0.0, 0.2 * normal(random)};
  }
  return rows;
}

TEST(MeanAndDeviation, IsThatOfTheTextbook) {
  EXPECT_DOUBLE_EQ(meanAndDeviation({3, 3, 3}).deviation, 0.0);
  const MeanAndDeviation result = meanAndDeviation({2, 4, 4, 4, 5, 5, 7, 9});
  EXPECT_DOUBLE_EQ(result.mean, 5.0);
  EXPECT_DOUBLE_EQ(result.deviation, 2.0) << "of the population, not the 2.138 of a sample";
  EXPECT_EQ(meanAndDeviation({}).mean, 0.0);
  EXPECT_EQ(meanAndDeviation({}).deviation, 0.0);
  EXPECT_EQ(meanAndDeviation({4}).deviation, 0.0);
}

TEST(RelationErrors, AreThoseComputedByHand) {
  const Trajectory rows = {{at(0), {0, 0, 0}}, {at(1), {1, 0, 0}}, {at(2), {1, 1, std::numbers::pi / 2}}};
  const RelationErrors errors =
      relationErrors(rows, {{at(0), at(1), {1.3, 0.4, 0.1}},                   // 0.5 m and 0.1 rad off
                            {at(1), at(2), {0, 1, std::numbers::pi / 2}},      // exact
                            {at(2), at(0), {-1, 1, -std::numbers::pi / 2}}});  // exact and backwards in time
  EXPECT_EQ(errors.used, 3);
  EXPECT_EQ(errors.left_out, 0);
  const double degrees = 0.1 / kDegree;
  EXPECT_NEAR(errors.translation.mean, 0.5 / 3, 1e-9);
  EXPECT_NEAR(errors.rotation.mean, degrees / 3, 1e-9);
  EXPECT_NEAR(errors.squared_translation.mean, 0.25 / 3, 1e-9);
  EXPECT_NEAR(errors.squared_rotation.mean, degrees * degrees / 3, 1e-9);
}

TEST(RelationErrors, TakeTheTranslationInTheFrameOfTheFirstPose) {
  const Trajectory rows = {{at(0), {5, 5, std::numbers::pi / 2}}, {at(1), {5, 7, std::numbers::pi / 2}}};
  EXPECT_NEAR(relationErrors(rows, {{at(0), at(1), {2, 0, 0}}}).translation.mean, 0.0, 1e-9);
}

TEST(RelationErrors, WrapTheRotation) {
  const Trajectory rows = {{at(0), {}}, {at(1), {0, 0, 179 * kDegree}}};
  EXPECT_NEAR(relationErrors(rows, {{at(0), at(1), {0, 0, -179 * kDegree}}}).rotation.mean, 2.0, 1e-9);
}

TEST(RelationErrors, TakeRowsWithinTwoMillisecondsAndInterpolateBetweenOthers) {
  const Trajectory rows = {{at(0), {0, 0, 0}}, {at(1), {10, 0, 0}}, {at(2), {20, 0, 0}}};
  EXPECT_NEAR(relationErrors(rows, {{at(0.0015), at(0.9985), {10, 0, 0}}}).translation.mean, 0.0, 1e-9);
  EXPECT_NEAR(relationErrors(rows, {{at(0.5), at(1.25), {7.5, 0, 0}}}).translation.mean, 0.0, 1e-9);
}

TEST(RelationErrors, CountAndLeaveOutRowsOutside) {
  const Trajectory rows = {{at(10), {0, 0, 0}}, {at(11), {1, 0, 0}}};
  const RelationErrors errors =
      relationErrors(rows, {{at(10), at(11), {1, 0, 0}}, {at(9.9), at(11), {9, 0, 0}}, {at(10), at(11.1), {9, 0, 0}}});
  EXPECT_EQ(errors.used, 1);
  EXPECT_EQ(errors.left_out, 2);
  EXPECT_NEAR(errors.translation.mean, 0.0, 1e-9);
  const RelationErrors none = relationErrors(rows, {{at(1), at(2), {}}});
  EXPECT_EQ(none.used, 0);
  EXPECT_EQ(none.translation.mean, 0.0);
}

TEST(ReadRelations, TakesThePlanarPartOfEachRow) {
  const Folder folder;
  const auto relations = readRelations(
      folder.write("a.relations", "976052905.167303 976052911.885496 -0.056990 -0.128430 0 0 0 -1.682210\n"));
  ASSERT_EQ(relations.size(), 1U);
  EXPECT_LT(std::abs((relations[0].from - fromMicroseconds(976'052'905'167'303)).count()), 500);
  EXPECT_LT(std::abs((relations[0].to - fromMicroseconds(976'052'911'885'496)).count()), 500);
  EXPECT_EQ(relations[0].T_from_to, (Pose2{-0.05699, -0.12843, -1.68221}));
}

TEST(ReadRelations, NamesFileAndLineOfABadRow) {
  const Folder folder;
  const std::string good = "1 2 0 0 0 0 0 0\n";
  for (const char* bad : {"1 2 0 0 0 0 0\n", "1e300 2 0 0 0 0 0 0\n", "1 -9e9 0 0 0 0 0 0\n"}) {
    const auto file = folder.write("bad.relations", good + bad);
    EXPECT_THAT(refusalOf([&] { readRelations(file); }), HasSubstr(file.string() + ":2")) << bad;
  }
  EXPECT_THROW(readRelations(folder / "missing"), std::runtime_error);
}

TEST(AbsoluteErrors, OfARotatedAndShiftedCopyAreZero) {
  const Trajectory truth = wanderingPath();
  const Pose2 T_truth_estimate{3.0, -40.0, 2.5};
  Trajectory estimate = truth;
  for (StampedPose& row : estimate) row.pose = T_truth_estimate.inverse() * row.pose;
  const AteErrors errors = absoluteErrors(estimate, truth);
  EXPECT_EQ(errors.used, 200);
  EXPECT_NEAR(errors.rmse, 0.0, 1e-9);
  EXPECT_NEAR(errors.max, 0.0, 1e-9);
  EXPECT_NEAR(errors.rotation_mean, 0.0, 1e-6);
  EXPECT_NEAR(errors.T_truth_estimate.x, T_truth_estimate.x, 1e-9);
  EXPECT_NEAR(errors.T_truth_estimate.y, T_truth_estimate.y, 1e-9);
  EXPECT_NEAR(errors.T_truth_estimate.theta, T_truth_estimate.theta, 1e-9);
}

TEST(AbsoluteErrors, KeepTheShiftWithoutAlignment) {
  const Trajectory truth = wanderingPath();
  Trajectory estimate = truth;
  for (StampedPose& row : estimate) row.pose.x += 0.3;
  const AteErrors errors = absoluteErrors(estimate, truth, false);
  EXPECT_NEAR(errors.rmse, 0.3, 1e-9);
  EXPECT_NEAR(errors.mean, 0.3, 1e-9);
  EXPECT_EQ(errors.T_truth_estimate, Pose2{});
}

TEST(AbsoluteErrors, DoNotForgiveAWrongScale) {
  Trajectory truth, estimate;
  for (int i = 0; i < 4; ++i) {  // corners of a square, 1 m from its middle
    const double angle = i * std::numbers::pi / 2;
    truth.push_back({at(i), {std::cos(angle), std::sin(angle), 0}});
    estimate.push_back({at(i), {1.1 * std::cos(angle), 1.1 * std::sin(angle), 5 * kDegree}});
  }
  const AteErrors errors = absoluteErrors(estimate, truth);
  EXPECT_NEAR(errors.rmse, 0.1, 1e-9);
  EXPECT_NEAR(errors.mean, 0.1, 1e-9);
  EXPECT_NEAR(errors.max, 0.1, 1e-9);
  EXPECT_NEAR(errors.rotation_mean, 5.0, 1e-9);
}

TEST(AbsoluteErrors, CountAndLeaveOutStampsOutside) {
  Trajectory truth = wanderingPath();
  const Trajectory estimate = truth;
  truth.resize(150);
  const AteErrors errors = absoluteErrors(estimate, truth);
  EXPECT_EQ(errors.used, 150);
  EXPECT_EQ(errors.left_out, 50);
  const AteErrors none = absoluteErrors({{at(1e6), {}}}, truth);
  EXPECT_EQ(none.used, 0);
  EXPECT_TRUE(std::isfinite(none.rmse) && std::isfinite(none.rotation_mean) && isFinite(none.T_truth_estimate));
}

TEST(RelationErrors, SpreadAsInTheTextbook) {
  const Trajectory rows = {{at(0), {0, 0, 0}}, {at(1), {1, 0, 0}}, {at(2), {2, 0, 0}}};
  const RelationErrors errors =
      relationErrors(rows, {{at(0), at(1), {1.3, 0.4, 10 * kDegree}}, {at(1), at(2), {1, 0.1, -30 * kDegree}}});
  EXPECT_NEAR(errors.translation.mean, 0.3, 1e-9);  // of 0.5 and 0.1
  EXPECT_NEAR(errors.translation.deviation, 0.2, 1e-9);
  EXPECT_NEAR(errors.rotation.mean, 20.0, 1e-9);
  EXPECT_NEAR(errors.rotation.deviation, 10.0, 1e-9);
  EXPECT_NEAR(errors.squared_translation.mean, 0.13, 1e-9);
  EXPECT_NEAR(errors.squared_translation.deviation, 0.12, 1e-9);
  EXPECT_NEAR(errors.squared_rotation.mean, 500.0, 1e-6);
  EXPECT_NEAR(errors.squared_rotation.deviation, 400.0, 1e-6);
}

TEST(AbsoluteErrors, OfRowsThatAreOffByDifferentLengths) {
  Trajectory truth, estimate;
  for (int i = 0; i < 4; ++i) {
    truth.push_back({at(i), {1.0 * i, 0, 0}});
    estimate.push_back({at(i), {1.0 * i, i == 1 ? 0.8 : i == 2 ? -0.4 : 0.0, 8 * i * kDegree}});
  }
  const AteErrors errors = absoluteErrors(estimate, truth, false);
  EXPECT_NEAR(errors.rmse, std::sqrt((0.64 + 0.16) / 4), 1e-9);
  EXPECT_NEAR(errors.mean, 0.3, 1e-9);
  EXPECT_NEAR(errors.max, 0.8, 1e-9) << "the largest, not the last";
  EXPECT_NEAR(errors.rotation_mean, 12.0, 1e-9);
}

TEST(WaypointErrors, AreThoseOfEachWaypointInTheFilesOwnFrames) {
  const Trajectory estimate = {{at(0), {0, 0, 0}}, {at(5), {5, 0, 10 * kDegree}}, {at(10), {10, 0, 20 * kDegree}}};
  const Trajectory waypoints = {{at(0), {0.3, 0.4, 170 * kDegree}},
                                {at(5), {5, 2, 10 * kDegree}},
                                {at(10), {10, 0, -170 * kDegree}},
                                {at(11), {0, 0, 0}}};
  const WaypointErrors errors = waypointErrors(estimate, waypoints);
  EXPECT_THAT(errors.position, testing::Pointwise(testing::DoubleNear(1e-9), {0.5, 2.0, 0.0}));
  EXPECT_THAT(errors.heading, testing::Pointwise(testing::DoubleNear(1e-9), {170.0, 0.0, 170.0}));
  EXPECT_EQ(errors.left_out, 1);
}

}  // namespace
}  // namespace slam::metrics_test
