// SPDX-License-Identifier: BSD-3-Clause
#include "tools/replay/estimates.hpp"

#include <array>
#include <charconv>
#include <cmath>
#include <string>

#include "tools/common/trajectory.hpp"

namespace slam {
namespace {

constexpr int kPoseDecimals = 9, kCovarianceDecimals = 15, kShareDecimals = 6;

void append(std::string& row, double value, int decimals) {
  std::array<char, 400> text{};  // the largest double has 309 digits before the point
  const auto end =
      std::isfinite(value)
          ? std::to_chars(text.data(), text.data() + text.size(), value, std::chars_format::fixed, decimals).ptr
          : text.data();
  row += ',';
  end == text.data() ? row.append("nan") : row.append(text.data(), end);
}

void append(std::string& row, const Pose2& pose) {
  for (const double value : {pose.x, pose.y, pose.theta}) append(row, value, kPoseDecimals);
}

}  // namespace

ScanEstimate estimateOf(const FrontEnd& front_end, const ScanOutcome& outcome, std::int64_t utime) {
  const PoseEstimate middle = front_end.estimate(outcome.stamp);
  const Eigen::Matrix3d jacobian = composeJacobians(middle.T_map_base, outcome.T_base_first).first;
  return {.utime = utime,
          .state = middle.state,
          .T_map_base = middle.T_map_base * outcome.T_base_first,
          .covariance = jacobian * middle.covariance * jacobian.transpose(),
          .T_odom_base = front_end.odometry(outcome.first).T_odom_base,
          .match = outcome.match};
}

EstimateWriter::EstimateWriter(const std::filesystem::path& file) : file_(file) {
  file_.write("t,state,x,y,theta,sxx,sxy,syy,sxt,syt,stt,odom_x,odom_y,odom_theta,status,overlap\n");
}

void EstimateWriter::write(const ScanEstimate& estimate) {
  std::string row = secondsText(estimate.utime) + ',' + nameOf(estimate.state);
  append(row, estimate.T_map_base);
  for (const auto& [i, j] : {std::pair(0, 0), {0, 1}, {1, 1}, {0, 2}, {1, 2}, {2, 2}}) {
    append(row, estimate.covariance(i, j), kCovarianceDecimals);
  }
  append(row, estimate.T_odom_base);
  row += ',';
  row += estimate.match.iterations > 0 ? nameOf(estimate.match.status) : "none";
  append(row, estimate.match.overlap, kShareDecimals);
  file_.write(row + '\n');
}

}  // namespace slam
