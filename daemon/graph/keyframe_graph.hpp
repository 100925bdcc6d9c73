// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <memory>
#include <span>
#include <utility>
#include <vector>

#include "core/keyframe.hpp"
#include "graph/pose_graph.hpp"
#include "matching/reference.hpp"
#include "matching/scan_points.hpp"

namespace slam {

/// A scan's point as a keyframe stores it.
Keyframe::Point keyframePoint(const ScanPoint& point);
/// The scan's point again, but for quantisation.
ScanPoint scanPoint(const Keyframe::Point& point, const Pose2& T_base_lidar);

/// A scan without the points that lie on what moves with the robot; where none does, the same one.
/// @param body   counterclockwise about the lidar
/// @param margin [m] by which they may lie beside it
std::shared_ptr<const StoredScan> scanWithout(const std::shared_ptr<const StoredScan>& scan, const BodyShape& body,
                                              double margin);

/// The pose graph of a map with the scan of each keyframe. Keyframe ids are the graph's node ids.
class KeyframeGraph {
 public:
  /// Adds a keyframe and the motion edge from its predecessor; its id must be size().
  void add(const Keyframe& keyframe);
  /// Adds a keyframe, or a part of a given map, without an edge.
  void add(std::shared_ptr<const StoredScan> scan, const Pose2& T_map_base);

  PoseGraph& graph() { return graph_; }
  const PoseGraph& graph() const { return graph_; }
  int size() const { return graph_.size(); }
  const Pose2& pose(int id) const { return graph_.pose(id); }
  const std::shared_ptr<const StoredScan>& scan(int id) const { return scans_[static_cast<std::size_t>(id)]; }

  /// Ids of the keyframes within `radius` [m] of a place, in rising order.
  std::vector<int> near(const Eigen::Vector2d& p_map, double radius) const { return graph_.near(p_map, radius); }
  /// A keyframe's points, with normals, in its own base. @param points out: replaced
  void points(int id, ScanPoints& points) const;
  /// Points of keyframe `newest` and of those before it, back to `oldest` or until their path is `length` [m] long, in
  /// newest's base. @param points out: replaced; every n-th, so that there are at most `limit`
  void gather(int newest, int oldest, double length, int limit, ScanPoints& points) const;
  /// Adds the keyframes to a reference in map.
  void addTo(Reference& reference, std::span<const int> ids) const;
  void setScan(int id, std::shared_ptr<const StoredScan> scan) {
    scans_[static_cast<std::size_t>(id)] = std::move(scan);
  }
  /// Forgets the keyframes from id `count` on. Only where no edge was added since.
  void truncate(int count);

 private:
  PoseGraph graph_;
  std::vector<std::shared_ptr<const StoredScan>> scans_;
  mutable ScanPoints scratch_;
};

}  // namespace slam
