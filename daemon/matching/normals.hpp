// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <Eigen/Core>
#include <span>

#include "matching/scan_points.hpp"

namespace slam {

struct NormalConfig {
  double min_support = 0.12;        ///< [m] a line is fitted over neighbours up to this far on either side
  int min_neighbours = 2;           ///< on either side together
  int max_neighbours = 8;           ///< on one side
  double max_gap = 0.20;            ///< [m] neighbours further apart than this are not one wall ...
  double max_gap_per_range = 0.09;  ///< [m/m] ... nor than this share of the range (1 degree beams at 79 degrees), or
                                    ///< so much more as the beams lie further apart than a degree
  double range_sigma = 0.015;       ///< [m] standard deviation of one lidar range
  double bearing_sigma = 0.0025;    ///< [rad] and of one bearing: a motor does not turn evenly
  double max_line_error = 0.04;     ///< [m] RMS distance of the neighbours from the line; more is a corner
  double fine_spacing = 0.0175;     ///< [rad] 1 degree, of which max_gap_per_range is told
  double in_a_row = 3.0;  ///< [1] standard deviations of ranges and bearings: points this near to one line are in a row
};

/// [1] Median angle between the beams of a scan by NormalConfig::fine_spacing, at least 1.
/// @param points in acquisition order  @param lidar [m] its position in the points' frame
double relativeSpacing(std::span<const ScanPoint> points, const Eigen::Vector2d& lidar,
                       const NormalConfig& config = {});

/// Fits a line through each point's neighbours in acquisition order and stores its normal and the normal's variance
/// range_sigma^2 / sum (s - mean s)^2, s the position along the line. Points where no line fits keep a zero normal;
/// those of them that go on a row of nearer points, further off than max_gap, may slide.
///
/// @param points   in acquisition order
/// @param lidar    [m] position of the lidar in the points' frame; normals look towards it
/// @return relativeSpacing() of the scan
double estimateNormals(ScanPoints& points, const Eigen::Vector2d& lidar, const NormalConfig& config = {});

}  // namespace slam
