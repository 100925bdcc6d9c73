// SPDX-License-Identifier: BSD-3-Clause
#include "core/scan.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace slam {
namespace {

/// The middle of a full degree.
Eigen::Vector2d directionOf(std::size_t degree) {
  const double bearing = (static_cast<double>(degree) + 0.5) * std::numbers::pi / 180.0;
  return {std::cos(bearing), std::sin(bearing)};
}

}  // namespace

int BodyShape::degrees() const {
  return static_cast<int>(std::count_if(millimetres.begin(), millimetres.end(), [](auto range) { return range > 0; }));
}

double BodyShape::middle() const {
  Eigen::Vector2d sum = Eigen::Vector2d::Zero();
  for (std::size_t i = 0; i < millimetres.size(); ++i) {
    if (millimetres[i] > 0) sum += directionOf(i);
  }
  return std::atan2(sum.y(), sum.x()) * 180.0 / std::numbers::pi;
}

BodyShape BodyShape::mirrored() const {
  BodyShape mirrored;
  std::reverse_copy(millimetres.begin(), millimetres.end(), mirrored.millimetres.begin());
  return mirrored;
}

BodyShape BodyShape::without(const BodyShape& other) const {
  BodyShape rest = *this;
  for (std::size_t i = 0; i < millimetres.size(); ++i) {
    if (other.millimetres[i] > 0) rest.millimetres[i] = 0;
  }
  return rest;
}

bool BodyShape::holds(const Eigen::Vector2d& p_lidar, double margin) const {
  for (std::size_t i = 0; i < millimetres.size(); ++i) {
    if (millimetres[i] > 0 && (0.001 * millimetres[i] * directionOf(i) - p_lidar).norm() <= margin) return true;
  }
  return false;
}

}  // namespace slam
