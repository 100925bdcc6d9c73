// SPDX-License-Identifier: BSD-3-Clause
#include "depth/depth_rays.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>

namespace slam {

void DepthRays::prepare(const DepthExtrinsics& extrinsics, const DepthIntrinsics& intrinsics, double bearing_step,
                        int most) {
  intrinsics_ = intrinsics;
  const Eigen::Matrix3d level = (Eigen::AngleAxisd(extrinsics.pitch, Eigen::Vector3d::UnitY()) *
                                 Eigen::AngleAxisd(extrinsics.roll, Eigen::Vector3d::UnitX()))
                                    .toRotationMatrix();
  const auto ray = [&](int u, int v) -> Eigen::Vector3d {
    return level * Eigen::Vector3d(1.0, (intrinsics.cx - u) / intrinsics.fx, (intrinsics.cy - v) / intrinsics.fy);
  };
  const auto bearing = [](const Eigen::Vector3d& r) { return std::atan2(r.y(), r.x()); };
  double left = -std::numbers::pi, right = std::numbers::pi;
  for (const int u : {0, intrinsics.width - 1}) {
    for (const int v : {0, intrinsics.height / 2, intrinsics.height - 1}) {
      left = std::max(left, bearing(ray(u, v)));
      right = std::min(right, bearing(ray(u, v)));
    }
  }
  const int beams = std::min(most, static_cast<int>((left - right) / bearing_step) + 1);
  bearing_step_ = static_cast<float>((left - right) / beams);
  bearing_min_ = static_cast<float>(right + 0.5 * (left - right) / beams);
  cos_.resize(static_cast<std::size_t>(beams));
  sin_.resize(static_cast<std::size_t>(beams));
  for (std::size_t beam = 0; beam < cos_.size(); ++beam) {
    const float direction = bearing_min_ + static_cast<float>(beam) * bearing_step_;
    cos_[beam] = std::cos(direction);
    sin_[beam] = std::sin(direction);
  }
  bands_.assign(static_cast<std::size_t>(beams) * kBands, {});
  pixels_.resize(intrinsics.pixels());
  for (int v = 0; v < intrinsics.height; ++v) {
    for (int u = 0; u < intrinsics.width; ++u) {
      const Eigen::Vector3d r = ray(u, v);
      const auto beam = static_cast<std::size_t>(
          std::clamp(static_cast<int>((bearing(r) - right) / (left - right) * beams), 0, beams - 1));
      const double across = r.head<2>().norm();
      pixels_[static_cast<std::size_t>(v * intrinsics.width + u)] = {
          static_cast<float>(across), static_cast<float>(r.z()), static_cast<std::uint16_t>(beam)};
      Band& band = bands_[beam * kBands + bandOfRow(static_cast<std::size_t>(v))];
      const auto slope = static_cast<float>(r.z() / across);
      band.slope_low = band.pixels == 0 ? slope : std::min(band.slope_low, slope);
      band.slope_high = band.pixels == 0 ? slope : std::max(band.slope_high, slope);
      ++band.pixels;
    }
  }
  boundRows();
}

void DepthRays::boundRows() {
  runs_.clear();
  rows_.clear();
  const auto width = static_cast<std::size_t>(intrinsics_.width);
  for (std::size_t first = 0; first < pixels_.size(); first += width) {
    const auto row = std::span(pixels_).subspan(first, width);
    const auto [across_low, across_high] = std::ranges::minmax(row, {}, &Pixel::across);
    const auto [up_low, up_high] = std::ranges::minmax(row, {}, &Pixel::up);
    const auto first_run = static_cast<std::uint32_t>(runs_.size());
    for (std::size_t u = 0; u < width; ++u) {
      if (u == 0 || row[u].beam != runs_.back().beam) runs_.push_back({row[u].beam, 0});
      runs_.back().end = static_cast<std::uint16_t>(u + 1);
    }
    rows_.push_back({across_low.across, across_high.across, up_low.up, up_high.up, first_run,
                     static_cast<std::uint32_t>(runs_.size())});
  }
}

}  // namespace slam
