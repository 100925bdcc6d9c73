// SPDX-License-Identifier: BSD-3-Clause
#include "tools/common/trajectory.hpp"

#include <cmath>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <limits>
#include <numbers>
#include <sstream>
#include <string>

#include "tools/files.hpp"

namespace slam::trajectory_test {
namespace {

using test::Folder;
using test::refusalOf;
using testing::HasSubstr;

constexpr std::int64_t kUtime = 976'052'857'278'917;

Timestamp at(double seconds) { return Timestamp(fromSeconds(seconds)); }

TEST(TrajectoryWriter, WritesRowsOfTum) {
  const Folder folder;
  TrajectoryWriter writer(folder / "a.tum");
  writer.write(kUtime, {1.5, -2.25, std::numbers::pi / 2});
  writer.close();
  std::istringstream row(test::contentOf(folder / "a.tum"));
  std::string stamp;
  double x, y, z, qx, qy, qz, qw;
  row >> stamp >> x >> y >> z >> qx >> qy >> qz >> qw;
  EXPECT_TRUE(row);
  EXPECT_THAT(stamp, testing::StartsWith("976052857.278917"));
  EXPECT_THAT(
      (std::vector{x, y, z, qx, qy, qz, qw}),
      testing::Pointwise(testing::DoubleNear(1e-6), {1.5, -2.25, 0.0, 0.0, 0.0, std::sqrt(0.5), std::sqrt(0.5)}));
}

TEST(TrajectoryWriter, IsReadBack) {
  const Folder folder;
  TrajectoryWriter writer(folder / "a.tum");
  const std::vector<Pose2> poses = {{0, 0, 0}, {1e-3, -1e3, 3.1}, {123.456789, 0, -3.1}};
  for (std::size_t i = 0; i < poses.size(); ++i) writer.write(kUtime + static_cast<std::int64_t>(i), poses[i]);
  writer.close();
  const Trajectory read = readTrajectory(folder / "a.tum");
  ASSERT_EQ(read.size(), poses.size());
  for (std::size_t i = 0; i < poses.size(); ++i) {
    const Timestamp stamp = fromMicroseconds(kUtime + static_cast<std::int64_t>(i));
    EXPECT_LT(std::abs((read[i].stamp - stamp).count()), 500) << "[ns]";
    EXPECT_NEAR(read[i].pose.x, poses[i].x, 1e-6);
    EXPECT_NEAR(read[i].pose.y, poses[i].y, 1e-6);
    EXPECT_NEAR(wrapAngle(read[i].pose.theta - poses[i].theta), 0.0, 1e-6);
  }
}

TEST(TrajectoryWriter, ReportsWhenRowsAreLost) {
  EXPECT_THROW(TrajectoryWriter("/dev/null/a.tum"), std::runtime_error);
  if (!std::filesystem::exists("/dev/full")) GTEST_SKIP() << "no /dev/full here";
  EXPECT_THROW(
      {
        TrajectoryWriter writer("/dev/full");
        for (int i = 0; i < 1000; ++i) writer.write(kUtime + i, {});
        writer.close();
      },
      std::runtime_error);
}

TEST(ReadTrajectory, SortsByStampAndKeepsTheOrderOfEqualOnes) {
  const Folder folder;
  const Trajectory read = readTrajectory(folder.write("a.tum",
                                                      "3.0 1 0 0 0 0 0 1\n"
                                                      "1.0 2 0 0 0 0 0 1\n"
                                                      "3.0 3 0 0 0 0 0 1\n"
                                                      "2.0 4 0 0 0 0 0 1\n"));
  std::vector<double> x;
  for (const StampedPose& row : read) x.push_back(row.pose.x);
  EXPECT_THAT(x, testing::ElementsAre(2, 4, 1, 3));
}

TEST(ReadTrajectory, NamesFileAndLineOfABadRow) {
  const Folder folder;
  const std::string good = "1.0 0 0 0 0 0 0 1\n";
  for (const char* bad : {"2.0 0 0 0 0 0 1\n", "2.0 0 0 0 0 0 0 1 5\n", "2.0 0 0 x 0 0 0 1\n", "2.0 nan 0 0 0 0 0 1\n",
                          "2.0 1e999 0 0 0 0 0 1\n", "inf 0 0 0 0 0 0 1\n", "1e300 0 0 0 0 0 0 1\n"}) {
    const auto file = folder.write("bad.tum", good + bad + good);
    EXPECT_THAT(refusalOf([&] { readTrajectory(file); }), HasSubstr(file.string() + ":2")) << bad;
  }
}

TEST(StampOf, HasADifferenceFromAnyOther) {
  EXPECT_EQ(stampOf(-1.5L), at(-1.5));
  EXPECT_GT(*stampOf(4.6e9L) - *stampOf(-4.6e9L), Duration(0));
  for (const long double seconds : {4.7e9L, -4.7e9L, 1e300L, std::numeric_limits<long double>::quiet_NaN()})
    EXPECT_FALSE(stampOf(seconds)) << seconds;
}

TEST(ReadTrajectory, TakesCommentsAndLineEndsOfWindows) {
  const Folder folder;
  EXPECT_EQ(readTrajectory(folder.write("a.tum", "# t x y z\n1.0 0 0 0 0 0 0 1\r\n\n2.0 0 0 0 0 0 0 1\r\n")).size(),
            2U);
}

TEST(ReadTrajectory, RefusesAFileWithoutRows) {
  const Folder folder;
  EXPECT_THROW(readTrajectory(folder.write("empty.tum", "")), std::runtime_error);
  EXPECT_THROW(readTrajectory(folder / "missing.tum"), std::runtime_error);
}

TEST(PoseAt, TakesTheRowWithinTwoMillisecondsAsItIs) {
  const Trajectory rows = {{at(1.0), {0, 0, 0}}, {at(1.1), {1, 0, 0}}};
  for (const double stamp : {1.0, 0.9981, 1.0019}) EXPECT_EQ(poseAt(rows, at(stamp)), Pose2{}) << stamp;
  EXPECT_EQ(poseAt(rows, at(1.1019)), (Pose2{1, 0, 0}));
}

TEST(PoseAt, TakesTheNearestOfTwoRowsWithinTwoMilliseconds) {
  const Trajectory rows = {{at(1.0), {0, 0, 0}}, {at(1.002), {1, 0, 0}}, {at(1.004), {2, 0, 0}}};
  EXPECT_EQ(poseAt(rows, at(1.0017)), (Pose2{1, 0, 0}));
  EXPECT_EQ(poseAt(rows, at(1.0023)), (Pose2{1, 0, 0}));
}

TEST(PoseAt, InterpolatesElsewhere) {
  const Trajectory rows = {{at(1.0), {0, 0, 3.0}}, {at(2.0), {1, 0, -3.0}}};
  const auto pose = poseAt(rows, at(1.5));
  ASSERT_TRUE(pose);
  EXPECT_NEAR(pose->x, 0.5, 1e-9);
  EXPECT_NEAR(std::abs(pose->theta), std::numbers::pi, 1e-9) << "the short way round";
  const auto quarter = poseAt({{at(0), {0, 0, 0}}, {at(1), {4, 8, 0}}}, at(0.25));
  ASSERT_TRUE(quarter);
  EXPECT_NEAR(quarter->x, 1.0, 1e-9);
  EXPECT_NEAR(quarter->y, 2.0, 1e-9);
}

TEST(PoseAt, IsNothingOutside) {
  const Trajectory rows = {{at(1.0), {}}, {at(2.0), {}}};
  EXPECT_FALSE(poseAt(rows, at(0.997)));
  EXPECT_FALSE(poseAt(rows, at(2.003)));
  EXPECT_FALSE(poseAt({}, at(1.0)));
}

}  // namespace
}  // namespace slam::trajectory_test
