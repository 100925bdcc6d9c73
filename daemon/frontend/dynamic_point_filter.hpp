// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <array>
#include <bitset>
#include <cstdint>
#include <optional>
#include <span>

#include "core/pose2.hpp"
#include "core/scan.hpp"
#include "core/timestamp.hpp"
#include "estimation/ekf_timeline.hpp"
#include "matching/deskew.hpp"
#include "matching/range_image.hpp"
#include "matching/scan_points.hpp"

namespace slam {

struct DynamicPointFilterConfig {
  double spacing = 0.5;  ///< [m] of way between the scans compared with: who goes along stands elsewhere in each
  double width = 0.1;    ///< [m] of a leg: a scan sees through a place where its beams lie closer together
  double open = 0.5;     ///< [1] of the reach: so near, a surface returns four times the light that it must
  double most = 0.5;     ///< [1] of the points told of: where more have moved, it is the motion that is wrong
};

/// Leaves out points that stand where an earlier scan saw through: people who go along with the robot, and what else
/// moves. The earlier scans are those of the last metres. After the visibility check of Pomerleau et al. (ICRA 2014,
/// "Long-term 3D map maintenance in dynamic environments").
///
/// No thread, clock or I/O; after construction no allocation.
class DynamicPointFilter {
 public:
  explicit DynamicPointFilter(const LidarMounting& lidar, const DynamicPointFilterConfig& config = {});

  /// @param points  with normals, in base at `stamp`, in acquisition order; those that moved are taken out
  /// @param filter  how the robot moved; where it does not reach back to the scan before the last, all begins anew
  /// @param beams   what the points were made of
  /// @param open    by beam: it looked, and nothing came back
  /// @param reach   [m] of the lidar
  void apply(ScanPoints& points, Timestamp stamp, const EkfTimeline& filter, std::span<const Beam> beams,
             std::span<const bool> open, double reach);
  /// Of the newest scan's points on lines: met by earlier scans, or standing where they saw through. Scans whose beams
  /// met a line less squarely than the newest one's do not count: it may be glass.
  const VisibilityTally& walls() const { return walls_; }
  /// The robot may be anywhere: what earlier scans saw says nothing of the next.
  void forget() { count_ = 0; }

 private:
  struct EarlierScan {
    RangeImage image;
    double sharp = 0.0;  // [m] nearer, its beams lie closer together than a leg is wide
    /// Of base at the stamp, seen from base where this scan was taken. The filter corrects a pose by its scan's match,
    /// so that the way up to a scan is known when the next one comes.
    Pose2 T_earlier_base;
    Timestamp stamp;
  };
  Pose2 follow(Timestamp stamp, const EkfTimeline& filter);
  void remember(const ScanPoints& points, Timestamp stamp, std::span<const Beam> beams, std::span<const bool> open,
                double reach);

  LidarMounting lidar_;
  DynamicPointFilterConfig config_;
  std::optional<Timestamp> last_;
  std::array<EarlierScan, 4> earlier_;  // newest first, with which nobody has left his place yet
  std::size_t count_ = 0;
  VisibilityTally walls_;
  // By point: one saw through; how many did, less those that met it.
  std::bitset<LaserScan::kCapacity> through_;
  std::array<std::int8_t, LaserScan::kCapacity> votes_{};
};

}  // namespace slam
