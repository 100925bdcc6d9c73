// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <Eigen/Core>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "core/pose2.hpp"
#include "graph/node_index.hpp"
#include "graph/node_set.hpp"

namespace slam {

enum class EdgeKind : std::uint8_t {
  kMotion,       ///< from one keyframe to the next
  kLoopClosure,  ///< between keyframes that saw the same place at different times; may be wrong
};

/// A measured relative pose of two nodes.
struct Edge {
  int from = 0, to = 0;
  Pose2 T_from_to;
  Eigen::Matrix3d information = Eigen::Matrix3d::Identity();  ///< inverse covariance of (x, y, theta) in `to` as
                                                              ///< measured, may be singular: a degenerate direction
  EdgeKind kind = EdgeKind::kMotion;
  bool revoked = false;  ///< taken back; counts for nothing
};

/// Poses and the measurements between them. Not safe for concurrent use.
class PoseGraph {
 public:
  /// @return its id, counting from 0
  int addNode(const Pose2& T_map_node);
  int addEdge(const Edge& edge);
  /// Forgets the nodes from `count` on, and their edges.
  void truncate(int count);
  void revoke(int edge) { setRevoked(edge, true); }
  void restore(int edge) { setRevoked(edge, false); }

  int size() const { return static_cast<int>(poses_.size()); }
  const Pose2& pose(int node) const { return poses_[static_cast<std::size_t>(node)]; }
  void setPose(int node, const Pose2& T_map_node);
  std::span<const Pose2> poses() const { return poses_; }
  std::span<const Edge> edges() const { return edges_; }
  /// Ids of the edges at a node, revoked ones too.
  std::span<const int> edgesAt(int node) const { return edges_of_[static_cast<std::size_t>(node)]; }
  /// Ids of the nodes within `radius` [m] of a place, in rising order.
  std::vector<int> near(const Eigen::Vector2d& p_map, double radius) const;

  /// A node and what is not known of its position relative to another.
  struct Reached {
    int node;
    double position_variance;  ///< [m^2] along the worst direction
    double heading_variance;   ///< [rad^2]
  };
  /// Nodes whose position relative to `anchor` is known to within `max_position_variance` [m^2], along the best chain
  /// of edges. The variance is a bound from above: several chains know more than the best one.
  std::vector<Reached> reach(int anchor, double max_position_variance) const;
  /// The same, in rising order of the position's variance, until these nodes are among them.
  std::vector<Reached> reach(int anchor, double max_position_variance, std::span<const int> wanted) const;

 private:
  /// What reach() asks of an edge.
  struct Link {
    int from, to;
    bool revoked;
    double position, heading;  // [m^2] along the worst direction, [rad^2]: what it leaves unknown
    double length;             // [m]
  };
  static Link linkOf(const Edge& edge);
  /// What reach() has found from an anchor, and where it goes on. Void when an edge changes.
  struct Search {
    struct Step {
      double position, cross, heading;  // [m^2, m rad, rad^2]
      int node;
      bool operator>(const Step& other) const { return position > other.position; }
    };
    int anchor = -1;            // -1: none
    std::vector<Step> queue;    // a heap, the least position first
    std::vector<Reached> done;  // in rising order of the position's variance
    std::vector<int> touched;   // nodes whose best_ is set
  };
  template <typename IsEnough>
  std::vector<Reached> reachUntil(int anchor, double max_position_variance, IsEnough&& isEnough) const;
  bool reachNext(double max_position_variance) const;
  void forgetSearch() const;
  void setRevoked(int edge, bool revoked) {
    forgetSearch();
    edges_[static_cast<std::size_t>(edge)].revoked = links_[static_cast<std::size_t>(edge)].revoked = revoked;
  }

  std::vector<Pose2> poses_;
  std::vector<Edge> edges_;
  std::vector<Link> links_;                 // by edge
  std::vector<std::vector<int>> edges_of_;  // edges at each node
  NodeIndex index_;
  mutable Search search_;             // the last one: a keyframe's questions have one anchor
  mutable std::vector<double> best_;  // of search_: [m^2], infinite where not reached
  mutable NodeSet wanted_;            // scratch of reach()
};

/// z - h(x): the difference between the measured and the present relative pose, in the measured pose's frame, weighted
/// by the information. @return squared Mahalanobis distance [1]
double chiSquare(const Edge& edge, const Pose2& T_map_from, const Pose2& T_map_to);

}  // namespace slam
