// SPDX-License-Identifier: BSD-3-Clause
#include "tools/eval/trust.hpp"

#include <cmath>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <limits>
#include <random>

#include "tools/files.hpp"
#include "tools/replay/estimates.hpp"

namespace slam::trust_test {
namespace {

using test::Folder;
using test::refusalOf;
using testing::HasSubstr;

constexpr double kSigma = 0.02, kHeadingSigma = 0.01;  // [m, rad]

Timestamp at(int i) { return Timestamp(fromSeconds(0.2 * i)); }

/// A drive of 100 s, and a robot in a map of its own frame that is as well off as it knows.
class Trust : public testing::Test {
 protected:
  Trust() {
    std::mt19937 random(3);
    std::normal_distribution<double> normal;
    Pose2 pose{4.0, -2.0, 1.0};
    const Pose2 T_map_truth = Pose2{4.0, -2.0, 1.0}.inverse();
    for (int i = 0; i <= 500; ++i) {
      truth.push_back({at(i), pose});
      const Pose2 right = T_map_truth * pose;
      known.push_back({.stamp = at(i),
                       .state = LocalisationState::kLocalised,
                       .T_map_base = {right.x + kSigma * normal(random), right.y + kSigma * normal(random),
                                      right.theta + kHeadingSigma * normal(random)}});
      known.back().covariance.diagonal() << kSigma * kSigma, kSigma * kSigma, kHeadingSigma * kHeadingSigma;
      pose = pose * Pose2{0.05, 0.0, 0.02};
    }
  }
  TrustErrors errors(const TrustOptions& options = {}) const { return trustErrors(known, truth, options); }

  Trajectory truth;
  std::vector<KnownPose> known;
};

TEST_F(Trust, IsFullWhereErrorsAreAsKnown) {
  const TrustErrors result = errors({.align_seconds = 10.0});
  EXPECT_EQ(result.scans, 501);
  EXPECT_EQ(result.localised, 501);
  EXPECT_EQ(result.wrong, 0);
  EXPECT_NEAR(result.nees, 3.0, 0.6);
  EXPECT_EQ(result.settled, 450);
  EXPECT_EQ(result.needless, 0);
}

TEST_F(Trust, CountsWhatIsSureAndWrong) {
  for (std::size_t i = 100; i < 200; ++i) known[i].T_map_base.x += 0.5;
  for (std::size_t i = 200; i < 300; ++i) known[i].T_map_base.theta += 0.1;
  for (std::size_t i = 100; i < 150; ++i) known[i].state = LocalisationState::kDegraded;  // it says so
  const TrustErrors result = errors();
  EXPECT_EQ(result.localised, 451);
  EXPECT_EQ(result.wrong, 150);
  EXPECT_NEAR(result.worst, 0.5, 0.1);
  EXPECT_NEAR(result.sureAndWrong(), 150.0 / 451.0, 1e-12);
}

TEST_F(Trust, EvaluatesAnErrorByTheVarianceInItsDirection) {
  for (KnownPose& pose : known) pose.covariance(0, 0) = 1.0;  // an endless corridor along the map's x
  for (std::size_t i = 300; i < 320; ++i) known[i].T_map_base.x += 1.0;
  EXPECT_EQ(errors().wrong, 0);
  for (std::size_t i = 300; i < 320; ++i) known[i].T_map_base.y += 1.0;
  EXPECT_EQ(errors().wrong, 0) << "oblique: still within three of its own";
  for (std::size_t i = 300; i < 320; ++i) known[i].T_map_base.x -= 1.0;
  EXPECT_EQ(errors().wrong, 20);
}

TEST_F(Trust, CallsANumberThatIsNoneWrong) {
  known[40].T_map_base.theta = std::numeric_limits<double>::quiet_NaN();
  known[41].covariance(0, 0) = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(errors().wrong, 2);
}

TEST_F(Trust, CountsWhoIsLostWhereItIsRight) {
  for (std::size_t i = 0; i < 150; ++i) known[i].state = LocalisationState::kInitialising;  // 10 s are granted
  for (std::size_t i = 400; i < 450; ++i) known[i].state = LocalisationState::kLost;
  for (std::size_t i = 420; i < 450; ++i) known[i].T_map_base.x += 1.0;  // rightly so
  EXPECT_EQ(errors().needless, 99 + 20);
}

TEST_F(Trust, MeasuresTheTimeUntilAKidnappingIsNoticed) {
  for (std::size_t i = 251; i <= 500; ++i) known[i].T_map_base.x += 5.0;
  EXPECT_FALSE(errors({.kidnapped = 50.0}).noticed);
  known[257].state = LocalisationState::kLost;
  EXPECT_NEAR(errors({.kidnapped = 50.0}).noticed.value(), 1.4, 1e-9);
  known[254].T_map_base.x -= 5.0;
  EXPECT_NEAR(errors({.kidnapped = 50.0}).noticed.value(), 0.8, 1e-9) << "right again";
}

TEST_F(Trust, ComparesInTheFilesOwnFrameWhereTheMapIsTheTruths) {
  EXPECT_GT(errors({.align_seconds = 0.0}).wrong, 490);
  const Pose2 T_truth_map{4.0, -2.0, 1.0};
  for (KnownPose& pose : known) pose.T_map_base = T_truth_map * pose.T_map_base;
  EXPECT_EQ(errors({.align_seconds = 0.0}).wrong, 0);
}

TEST_F(Trust, LeavesOutWhatTheTruthDoesNotCover) {
  truth.erase(truth.begin(), truth.begin() + 100);
  EXPECT_EQ(errors().left_out, 100);
  EXPECT_EQ(errors().scans, 401);
}

TEST(ReadEstimates, ReadsWhatSlamReplayWrites) {
  const Folder folder;
  ScanEstimate estimate{.utime = 1'700'000'000'000'050,
                        .state = LocalisationState::kDegraded,
                        .T_map_base = {-12.5, 0.25, -3.125},
                        .T_odom_base = {},
                        .match = {}};
  estimate.covariance << 1.0, 0.1, 0.2, 0.1, 2.0, 0.3, 0.2, 0.3, 3.0;
  EstimateWriter writer(folder / "a.csv");
  writer.write(estimate);
  writer.close();
  const auto read = readEstimates(folder / "a.csv");
  ASSERT_EQ(read.size(), 1U);
  EXPECT_EQ(read[0].state, LocalisationState::kDegraded);
  EXPECT_EQ(read[0].T_map_base.theta, -3.125);
  EXPECT_TRUE(read[0].covariance.isApprox(estimate.covariance, 1e-12));
  EXPECT_NEAR(toSeconds(read[0].stamp.time_since_epoch()), 1.70000000000005e9, 1e-5);
}

TEST(ReadEstimates, RefusesWhatIsNone) {
  const Folder folder;
  const auto refusal = [&](const std::string& text) {
    folder.write("a.csv", text);
    return refusalOf([&] { readEstimates(folder / "a.csv"); });
  };
  const std::string header = "t,state,x,y,theta,sxx,sxy,syy,sxt,syt,stt\n";
  EXPECT_THAT(refusal(""), HasSubstr("a.csv:1: not written by slam-replay --estimates"));
  EXPECT_THAT(refusal("1 2 3 0 0 0 1 0\n"), HasSubstr("a.csv:1"));
  EXPECT_THAT(refusal(header), HasSubstr("no estimate"));
  EXPECT_THAT(refusal(header + "1,localised,1,2,3,1,0,1,0,0,1\n2,localised,1\n"), HasSubstr("a.csv:3"));
  EXPECT_THAT(refusal(header + "1,sure,1,2,3,1,0,1,0,0,1\n"), HasSubstr("a.csv:2"));
  for (const char* stamp : {"nan", "1e300", "-9e9"})
    EXPECT_THAT(refusal(header + stamp + ",lost,1,2,3,1,0,1,0,0,1\n"), HasSubstr("a.csv:2")) << stamp;
}

}  // namespace
}  // namespace slam::trust_test
