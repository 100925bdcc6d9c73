// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <optional>
#include <span>
#include <vector>

#include "matching/correlative.hpp"
#include "matching/reference.hpp"
#include "posegraph/global_search.hpp"
#include "posegraph/keyframe_graph.hpp"

namespace slam {

struct RelocalisationConfig {
  GlobalSearchConfig search;
  double interval = 0.5;          ///< [m] of path between two searches
  double query_length = 8.0;      ///< [m] of the newest path are searched for as one scan
  int max_query_points = 1440;    ///< of it
  int max_search_points = 240;    ///< of it are searched for, as many along the walls as across them
  double max_range = 40.0;        ///< [m] points further from the robot are left out: the map is too coarse for them
  double min_score = 0.35;        ///< [1] of the search
  int places = 6;                 ///< best places of the search that are compared by point-to-line matching ...
  double place_share = 0.8;       ///< [1] ... if they reach such a share of the best one's score
  double submap_radius = 40.0;    ///< [m] of the map around a place are matched against
  double fine_kernel = 0.25;      ///< [m] a point this far from the map no longer counts when places are compared
  double min_overlap = 0.50;      ///< [1] of the query's points agree with the map
  double ambiguity = 0.92;        ///< [1] a second place with such a share of the best one's score: both are doubtful
  double sure_overlap = 0.70;     ///< [1] with so many and ...
  double sure_runner_up = 0.75;   ///< [1] ... a second place no better, one find is enough
  double confirm_path = 1.0;      ///< [m] otherwise another find, so much further on ...
  double confirm_distance = 0.4;  ///< [m] ... must agree to this
  double confirm_rotation = 0.1;  ///< [rad]
};

/// Finds a robot that does not know where it is in a map: the segment that it has mapped since is searched for in the
/// whole map, the best places are compared by point-to-line matching, and the best one is believed when no other fits
/// as well and, unless it is very clear, a second find further along the path agrees.
///
/// Points are drawn from walls of all directions alike (normal-space sampling), so that the few that tell one place of
/// a corridor from the next weigh as much as the many that do not. [Rusinkiewicz 2001] S. Rusinkiewicz and M. Levoy,
/// "Efficient variants of the ICP algorithm", Proc. 3DIM 2001.
class Relocalisation {
 public:
  Relocalisation(const RelocalisationConfig& config, const ReferenceConfig& reference, const MatchConfig& match);

  /// Begins a new segment, to be looked for among the keyframes `map`.
  void begin(const KeyframeGraph& keyframes, std::span<const int> map);
  /// The map stays, the segment is another one.
  void begin();

  struct Found {
    Pose2 T_map_newest;
    MatchResult match;
    bool confirmed = false;  ///< believed
  };
  /// @param oldest first keyframe of the segment
  /// @return what was found at this keyframe, if it was searched for at all
  std::optional<Found> search(const KeyframeGraph& keyframes, int oldest, int newest);

  /// Looks around the pose of `newest` only, which a person gave.
  std::optional<Found> searchNear(const KeyframeGraph& keyframes, int oldest, int newest, const SearchWindow& window);

  struct Counters {
    int searches = 0, found = 0, ambiguous = 0, refused = 0, confirmed = 0;
  };
  const Counters& counters() const { return counters_; }

 private:
  struct Find {
    Pose2 T_map_segment;
    double path;  // [m] driven in the segment
  };
  void sampleDirections();
  bool seenThroughWall(const Eigen::Vector2d& from, const Eigen::Vector2d& to) const;
  double fineScore(const Pose2& T_map_query) const;
  struct Candidate {
    Pose2 T_map_query;
    MatchResult match;
    double score = 0.0;
  };
  std::vector<Candidate> candidates(const KeyframeGraph& keyframes);
  void buildSubmap(const KeyframeGraph& keyframes, const Eigen::Vector2d& centre);
  bool confirm(const Find& find, const Pose2& T_segment_base, double overlap, double runner_up);

  RelocalisationConfig config_;
  MatchConfig match_;
  Reference submap_;
  CorrelativeMatcher matcher_;
  std::optional<GlobalSearch> global_;
  std::vector<char> in_map_;  // by keyframe
  std::vector<Find> finds_;   // of this segment, not yet believed
  ScanPoints query_;
  std::vector<Eigen::Vector2d> seen_from_;                  // [m] the lidar, for each of its points
  std::vector<Eigen::Vector2d> sample_, sample_seen_from_;  // [m] of the query
  double path_ = 0.0, searched_at_ = -1e9;                  // [m]
  int seen_ = -1;                                           // keyframe that path_ ends at
  Counters counters_;
};

}  // namespace slam
