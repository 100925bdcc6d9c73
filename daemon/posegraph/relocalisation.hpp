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
  double min_score = 0.45;        ///< [1] of the search
  double submap_radius = 20.0;    ///< [m] of the map around a place are matched against
  double min_overlap = 0.60;      ///< [1] of the query's points agree with the map
  double ambiguity = 0.90;        ///< [1] a second place with such a share of the score makes a place doubtful
  double sure_overlap = 0.75;     ///< [1] with so many and ...
  double sure_runner_up = 0.75;   ///< [1] ... a second place no better, one find is enough
  double confirm_path = 1.0;      ///< [m] otherwise another find, so much further on ...
  double confirm_distance = 0.4;  ///< [m] ... must agree to this
  double confirm_rotation = 0.1;  ///< [rad]
};

/// Finds a robot that does not know where it is in a map: the segment that it has mapped since is searched for in the
/// whole map, compared with the map there by point-to-line matching, and believed when no other place fits as well and,
/// unless it is very clear, a second find further along the path agrees.
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
  double path_ = 0.0, searched_at_ = -1e9;  // [m]
  int seen_ = -1;                           // keyframe that path_ ends at
  Counters counters_;
};

}  // namespace slam
