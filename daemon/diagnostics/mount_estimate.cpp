// SPDX-License-Identifier: BSD-3-Clause
#include "diagnostics/mount_estimate.hpp"

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>

namespace slam {
namespace {

struct Middle {
  double median, sigma;
};

template <std::size_t kSize>
Middle middleOf(std::array<double, kSize> values, std::size_t count) {
  const auto end = values.begin() + static_cast<std::ptrdiff_t>(count);
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(count / 2);
  std::nth_element(values.begin(), middle, end);
  const double median = *middle;
  for (auto at = values.begin(); at != end; ++at) *at = std::abs(*at - median);
  std::nth_element(values.begin(), middle, end);
  return {median, 1.4826 * *middle / std::sqrt(static_cast<double>(count))};
}

}  // namespace

void MountEstimate::add(const Pose2& scans, const Pose2& wheels) {
  const double turn = scans.theta;
  if (std::abs(turn) < config_.least_turn || std::abs(wheels.theta - turn) > config_.same_turn * std::abs(turn)) return;
  const Eigen::Matrix2d lever = Eigen::Rotation2Dd(turn).toRotationMatrix() - Eigen::Matrix2d::Identity();
  const Eigen::Vector2d offset = lever.inverse() * (scans.translation() - wheels.translation());
  Turns& turns = turn > 0.0 ? left_ : right_;
  turns.x[turns.count % turns.x.size()] = offset.x();
  turns.y[turns.count % turns.x.size()] = offset.y();
  ++turns.count;
}

std::optional<Eigen::Vector2d> MountEstimate::offset() const {
  if (left_.count < config_.least_turns || right_.count < config_.least_turns) return std::nullopt;
  const std::size_t left = std::min(left_.count, left_.x.size()), right = std::min(right_.count, right_.x.size());
  const Middle lx = middleOf(left_.x, left), rx = middleOf(right_.x, right);
  const Middle ly = middleOf(left_.y, left), ry = middleOf(right_.y, right);
  const Eigen::Vector2d offset(0.5 * (lx.median + rx.median), 0.5 * (ly.median + ry.median));
  const double sigma = 0.5 * std::max(std::hypot(lx.sigma, rx.sigma), std::hypot(ly.sigma, ry.sigma));
  const bool is_sure = offset.norm() > std::max(config_.least_offset, config_.sure * sigma);
  return is_sure ? std::optional(offset) : std::nullopt;
}

}  // namespace slam
