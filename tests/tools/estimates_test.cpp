// SPDX-License-Identifier: BSD-3-Clause
#include "tools/replay/estimates.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <limits>
#include <locale>
#include <memory>

#include "frontend/drive.hpp"
#include "tools/files.hpp"

namespace slam::estimates_test {
namespace {

using test::contentOf;
using test::Folder;

const std::string kColumns = "t,state,x,y,theta,sxx,sxy,syy,sxt,syt,stt,odom_x,odom_y,odom_theta,status,overlap\n";

std::string written(const std::vector<ScanEstimate>& estimates) {
  const Folder folder;
  EstimateWriter writer(folder / "a.csv");
  for (const ScanEstimate& estimate : estimates) writer.write(estimate);
  writer.close();
  return contentOf(folder / "a.csv");
}

ScanEstimate someEstimate() {
  ScanEstimate estimate{.utime = 1'700'000'000'000'050,
                        .state = LocalisationState::kLocalised,
                        .T_map_base = {-1234.5, 0.25, -3.125},
                        .T_odom_base = {1e-9, -2.0, 0.5},
                        .match = {}};
  estimate.covariance << 1e-8, 2e-9, 3e-9, 2e-9, 0.5, 1e-15, 3e-9, 1e-15, 1e6;
  estimate.match.iterations = 4;
  estimate.match.status = MatchStatus::kConverged;
  estimate.match.overlap = 0.75;
  return estimate;
}

const std::string kRow =
    "1700000000.000050,localised,-1234.500000000,0.250000000,-3.125000000,"
    "0.000000010000000,0.000000002000000,0.500000000000000,0.000000003000000,0.000000000000001,1000000.000000000000000,"
    "0.000000001,-2.000000000,0.500000000,converged,0.750000\n";

TEST(EstimateWriter, WritesARowOfPlainDecimalsForEachScan) {
  EXPECT_EQ(written({}), kColumns);
  EXPECT_EQ(written({someEstimate(), someEstimate()}), kColumns + kRow + kRow);
}

TEST(EstimateWriter, WritesTheSameInEveryLocale) {
  struct Continental : std::numpunct<char> {
    char do_decimal_point() const override { return ','; }
    char do_thousands_sep() const override { return '.'; }
    std::string do_grouping() const override { return "\3"; }
  };
  const std::locale before = std::locale::global(std::locale(std::locale(), new Continental));
  const std::string text = written({someEstimate()});
  std::locale::global(before);
  EXPECT_EQ(text, kColumns + kRow);
}

TEST(EstimateWriter, WritesNanForWhatIsNotFinite) {
  ScanEstimate estimate = someEstimate();
  estimate.T_map_base.x = std::numeric_limits<double>::quiet_NaN();
  estimate.T_map_base.y = -std::numeric_limits<double>::infinity();
  EXPECT_THAT(written({estimate}), testing::HasSubstr(",localised,nan,nan,-3.125000000,"));
}

TEST(EstimateWriter, NamesStateAndStatus) {
  ScanEstimate estimate = someEstimate();
  const auto fields = [&] {
    const std::string row = written({estimate}).substr(kColumns.size());
    const std::size_t status = row.rfind(',', row.rfind(',') - 1) + 1;
    return row.substr(18, row.find(',', 18) - 18) + " " + row.substr(status, row.rfind(',') - status);
  };
  const std::pair<LocalisationState, const char*> states[] = {{LocalisationState::kInitialising, "initialising"},
                                                              {LocalisationState::kLocalised, "localised"},
                                                              {LocalisationState::kDegraded, "degraded"},
                                                              {LocalisationState::kLost, "lost"}};
  for (const auto& [state, word] : states) {
    estimate.state = state;
    EXPECT_EQ(fields(), word + std::string(" converged"));
  }
  const std::pair<MatchStatus, const char*> statuses[] = {{MatchStatus::kConverged, "converged"},
                                                          {MatchStatus::kUnobservable, "unobservable"},
                                                          {MatchStatus::kIterationLimit, "iteration_limit"},
                                                          {MatchStatus::kTooFewPairs, "too_few_pairs"},
                                                          {MatchStatus::kLowOverlap, "low_overlap"},
                                                          {MatchStatus::kAmbiguous, "ambiguous"}};
  for (const auto& [status, word] : statuses) {
    estimate.match.status = status;
    EXPECT_EQ(fields(), "lost " + std::string(word));
  }
  estimate.match = {};
  EXPECT_EQ(fields(), "lost none") << "the matcher never saw the scan";
}

TEST(EstimateWriter, RefusesAPathThatItCannotWrite) {
  EXPECT_EQ(test::refusalOf([] { EstimateWriter("/dev/null/a.csv"); }),
            "/dev/null/a.csv: cannot write: its folder cannot be made: Not a directory");
}

TEST(EstimateOf, TakesPoseAndCovarianceToTheScansOwnStamp) {
  test::Drive drive(test::Room{}, {});
  drive.wheels.scale = 1.03;
  drive.wheels.turn_scale = 0.98;
  drive.gyro.there = false;
  drive.run(3.0, {0.3, 0.0, 0.4});
  const auto& front_end = drive.front_end;
  ScanOutcome outcome = drive.last;
  ASSERT_TRUE(outcome.fused);
  outcome.T_base_first = {-0.4, 0.3, 0.2};  // more than there is in a turn, so that the lever shows
  const PoseEstimate middle = front_end->estimate(outcome.stamp);
  const ScanEstimate estimate = estimateOf(*front_end, outcome, 7);
  EXPECT_EQ(estimate.utime, 7);
  EXPECT_EQ(estimate.state, middle.state);
  EXPECT_EQ(estimate.T_map_base, middle.T_map_base * outcome.T_base_first);
  EXPECT_EQ(estimate.T_odom_base, front_end->odometry(outcome.first).T_odom_base);
  EXPECT_EQ(estimate.match.overlap, outcome.match.overlap);
  constexpr double kStep = 1e-6;
  Eigen::Matrix3d jacobian;  // by central differences
  for (int i = 0; i < 3; ++i) {
    const Eigen::Vector3d step = kStep * Eigen::Vector3d::Unit(i), at = middle.T_map_base.vector();
    const Pose2 more = Pose2::fromVector(at + step) * outcome.T_base_first;
    const Pose2 less = Pose2::fromVector(at - step) * outcome.T_base_first;
    jacobian.col(i) = (more.vector() - less.vector()) / (2.0 * kStep);
  }
  const Eigen::Matrix3d expected = jacobian * middle.covariance * jacobian.transpose();
  EXPECT_LT((estimate.covariance - expected).norm(), 1e-6 * expected.norm());
  EXPECT_GT((expected - middle.covariance).norm(), 1e-3 * expected.norm()) << "the lever shows";
}

}  // namespace
}  // namespace slam::estimates_test
