// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include "matching/deskew.hpp"
#include "matching/normals.hpp"
#include "support/simulated/room.hpp"

namespace slam::test {

/// Points with normals of one scan taken at rest.
inline ScanPoints scanPoints(const Room& room, const Pose2& pose, std::mt19937& random) {
  const LaserScan scan = room.scan(pose, random);
  ScanPoints points;
  deskew(scan, {scan.range_min, scan.range_max}, scan.stamp, Pose2{}, PoseHistory(2), points);
  estimateNormals(points, Eigen::Vector2d::Zero(), {.range_sigma = std::max(0.005, room.range_sigma)});
  return points;
}

}  // namespace slam::test
