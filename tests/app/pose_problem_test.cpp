// SPDX-License-Identifier: BSD-3-Clause
#include "app/pose_problem.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace slam::pose_problem_test {
namespace {

using enum LocalisationState;
using testing::HasSubstr;
using testing::StartsWith;

PoseSnapshot poseOf(LocalisationState state) {
  PoseSnapshot pose;
  pose.pose.state = state;
  pose.scans = 7;
  pose.tracking = {.begun = true, .placed = true, .failures = 0, .points = 200, .needed = 40};
  return pose;
}

std::string wordsOf(const PoseSnapshot& pose, bool has_scans) {
  const Trouble trouble = poseTrouble(pose, has_scans);
  return trouble.since + trouble.problem.words();
}

TEST(PoseProblem, IsNoneOnlyWhereItIsLocalised) {
  EXPECT_FALSE(poseTrouble(poseOf(kLocalised), false).problem);
  for (const LocalisationState state : {kInitialising, kDegraded, kLost})
    EXPECT_TRUE(poseTrouble(poseOf(state), true).problem);
  EXPECT_EQ(poseTrouble(poseOf(kLocalised), true).text(), "pose localised");
}

TEST(PoseProblem, NameTheLidarThatAPoseWaitsFor) {
  for (const LocalisationState state : {kInitialising, kDegraded, kLost})
    EXPECT_THAT(wordsOf(poseOf(state), false), HasSubstr("waits for the lidar"));
}

TEST(PoseProblem, NameNoSensorAloneWhereAllAreSilent) {
  PoseSnapshot pose = poseOf(kLost);
  pose.tracking.silent = true;
  EXPECT_THAT(wordsOf(pose, false), StartsWith("wheels, gyro and lidar are all silent"));
  pose.pose.state = kInitialising;
  pose.tracking.begun = false;
  EXPECT_THAT(wordsOf(pose, false), HasSubstr("waits for the lidar")) << "at the start there is nothing to lose";
}

TEST(PoseProblem, DistinguishScansThatShowNothingFromThoseThatDoNotMatch) {
  PoseSnapshot pose = poseOf(kDegraded);
  pose.tracking.failures = 12;
  EXPECT_THAT(wordsOf(pose, true), StartsWith("waits for scans that match the map: the last 12 do not"));
  pose.tracking.points = 11;
  EXPECT_THAT(wordsOf(pose, true), HasSubstr("11 points where 40 are needed"));
  pose.tracking.range_noise = 0.312;
  EXPECT_THAT(wordsOf(pose, true), HasSubstr("ranges scatter by 0.31 m")) << "points that are not used are not few";
  pose.echo_finding = EchoWatch::Finding::kNoEcho;
  EXPECT_THAT(wordsOf(pose, true), HasSubstr("wide hall"));
}

TEST(PoseProblem, GivesHowFarScansAndWheelsDiffer) {
  PoseSnapshot pose = poseOf(kDegraded);
  pose.tracking.contradiction = 0.424;
  EXPECT_THAT(wordsOf(pose, true), StartsWith("scans and wheels tell ways that differ by 0.42 m"));
  EXPECT_THAT(wordsOf(pose, true), HasSubstr("was the robot pushed"));
}

TEST(PoseProblem, NamesTheFloorsThatAreNotCertain) {
  PoseSnapshot pose = poseOf(kDegraded);
  pose.tracking.assumed = true;
  EXPECT_THAT(wordsOf(pose, true), HasSubstr("as in a lift"));
  EXPECT_THAT(wordsOf(pose, true), HasSubstr("store.floors"));
}

TEST(PoseProblem, NameScansThatTurnAsTheGyroDoesNot) {
  PoseSnapshot pose = poseOf(kDegraded);
  pose.tracking.contradiction = 0.424;
  pose.tracking.scan_drift = -0.004;
  EXPECT_THAT(wordsOf(pose, true),
              StartsWith("scans turn by -13.8 deg per minute against a gyro that was right at rest"));
  EXPECT_THAT(wordsOf(pose, true), HasSubstr("half of the scan contradict the other half"));
  pose.tracking.failures = 3;
  EXPECT_THAT(wordsOf(pose, true), StartsWith("scans turn by")) << "and the lidar is not said to be covered";
}

TEST(PoseProblem, ReportWhatHelpsARobotThatIsLookedFor) {
  EXPECT_THAT(wordsOf(poseOf(kLost), true), HasSubstr("slamctl set-pose"));
  PoseSnapshot pose = poseOf(kInitialising);
  EXPECT_THAT(wordsOf(pose, true), HasSubstr("found in the map"));
  pose.tracking.begun = false;
  EXPECT_THAT(wordsOf(pose, true), HasSubstr("a scan that can be placed"));
  pose.scans = 0;
  EXPECT_THAT(wordsOf(pose, true), HasSubstr("the first scan"));
}

TEST(PoseWatch, LeavesAPoseThatIsAwayForAMomentAlone) {
  using namespace std::chrono_literals;
  PoseWatch watch;
  const auto problemAfter = [&](LocalisationState state, Duration time) {
    const auto troubles = watch.troubles(poseOf(state), true, Timestamp(100s) + time);
    return !troubles.empty() && troubles.front().problem;
  };
  EXPECT_FALSE(problemAfter(kInitialising, 0s));
  EXPECT_FALSE(problemAfter(kDegraded, 3900ms));
  EXPECT_TRUE(problemAfter(kDegraded, 4s));
  EXPECT_TRUE(watch.troubles(poseOf(kLocalised), true, Timestamp(105s)).empty());
  EXPECT_FALSE(problemAfter(kDegraded, 6s)) << "it was there meanwhile";
  EXPECT_TRUE(problemAfter(kLost, 6s)) << "which is never a matter of a moment";
}

TEST(PoseWatch, NotesTheFirstPoseOnce) {
  PoseWatch watch;
  EXPECT_FALSE(watch.isFirst(poseOf(kInitialising)));
  EXPECT_TRUE(watch.isFirst(poseOf(kLocalised)));
  EXPECT_FALSE(watch.isFirst(poseOf(kLocalised)));
}

}  // namespace
}  // namespace slam::pose_problem_test
