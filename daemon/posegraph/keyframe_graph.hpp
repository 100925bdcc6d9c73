// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <memory>
#include <span>
#include <vector>

#include "core/keyframe.hpp"
#include "matching/reference.hpp"
#include "matching/scan_points.hpp"
#include "posegraph/pose_graph.hpp"

namespace slam {

/// The pose graph of a map with the scan of each keyframe. Keyframe ids are the graph's node ids.
class KeyframeGraph {
 public:
  /// Adds a keyframe and the motion edge from its predecessor; its id must be size().
  void add(const Keyframe& keyframe);
  /// Adds a node of a stored map, without an edge.
  void add(std::shared_ptr<const StoredScan> scan, const Pose2& T_map_base);

  PoseGraph& graph() { return graph_; }
  const PoseGraph& graph() const { return graph_; }
  int size() const { return graph_.size(); }
  const Pose2& pose(int id) const { return graph_.pose(id); }
  const std::shared_ptr<const StoredScan>& scan(int id) const { return scans_[static_cast<std::size_t>(id)]; }

  /// Ids of the keyframes within `radius` [m] of a place.
  std::vector<int> near(const Eigen::Vector2d& p_map, double radius) const;
  /// A keyframe's points, with normals, in its own base. @param points out: replaced
  void points(int id, ScanPoints& points) const;
  /// Adds the keyframes to a reference in map.
  void addTo(Reference& reference, std::span<const int> ids) const;

 private:
  PoseGraph graph_;
  std::vector<std::shared_ptr<const StoredScan>> scans_;
  mutable ScanPoints scratch_;
};

}  // namespace slam
