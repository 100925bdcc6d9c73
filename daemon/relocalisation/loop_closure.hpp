// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "graph/keyframe_graph.hpp"
#include "matching/correlative.hpp"
#include "matching/reference.hpp"
#include "relocalisation/place_search.hpp"

namespace slam {

struct LoopClosureConfig {
  double active_sigma = 0.05;      ///< [m] keyframes known this well relative to the robot are one map with it
  double search_interval = 0.5;    ///< [m] between two searches
  double max_search = 20.0;        ///< [m] no drift is taken to be larger
  double submap_radius = 8.0;      ///< [m] keyframes this near to a candidate are matched against
  int max_submap = 40;             ///< keyframes at most
  double query_length = 3.0;       ///< [m] of the newest path are matched as one scan
  int max_query_points = 720;      ///< of it
  double min_overlap = 0.60;       ///< [1] of the query's points agree with the submap
  double sure_overlap = 0.70;      ///< [1] so many, in a window below sure_window, and one match is enough
  double sure_window = 1.0;        ///< [m] in wider ones places are compared by all beams
  double map_radius = 20.0;        ///< [m] of the old map, in which they are; ...
  double unknown_as_wall = 0.4;    ///< [1] ... a beam ends where it has not looked at such a share of a wall's rate, so
                                   ///< that a place across its border is as good as one within
  double consistency = 0.3;        ///< [m] two closures agree when they differ by less over the path between them ...
  double pending_distance = 15.0;  ///< [m] ... which is at most so long, and ...
  double agreement_distance = 4.0;  ///< [m] ... in a wide window no shorter: the same scans prove nothing twice
  double translation_sigma = 0.02;  ///< [m] floor of a closure's standard deviation
  double rotation_sigma = 0.005;    ///< [rad]
  double max_chi_square = 16.0;     ///< [1] an accepted closure that contradicts the rest by more is revoked
  double window_sigmas = 3.0;       ///< [1] of the place's uncertainty, to each side of the searched window ...
  double min_search = 0.30;         ///< [m] ... which is at least so wide ...
  double min_turn = 0.05;           ///< [rad] ... and at least ...
  double max_turn = 0.8;            ///< [rad] ... and at most turned by so much
  double submap_extent = 51.2;      ///< [m] side of the square that is matched against
  std::int64_t work_at_once =
      100'000'000;  ///< [points] compared with the map at one keyframe, see RelocalisationConfig

  void visitSettings(auto& v) {
    v.expert("max_search", max_search, "m", 0.3, 50.0,
             "Loop closures are searched up to this distance from the expected place.");
    v.expert("min_overlap", min_overlap, "1", 0.1, 1.0,
             "A loop closure needs at least this share of the newest points to agree with the old map.");
    v.expert(
        "sure_overlap", sure_overlap, "1", 0.1, 1.0,
        "A loop closure in a narrow window needs no second one if this share of its points agrees with the old map.");
    v.expert("consistency", consistency, "m", 0.01, 5.0,
             "Two loop closures confirm each other if they differ by less than this over the path between them.");
    v.expert("max_chi_square", max_chi_square, "1", 1.0, 10000.0,
             "A loop closure is removed when its chi-square error in the pose graph is above this.");
    v.expert("active_sigma", active_sigma, "m", 0.005, 5.0,
             "Scans are matched against keyframes whose position relative to the robot has a standard deviation "
             "below this.");
  }
};

/// Information of a closure: of the match, its covariance not below the floor, in the directions that it saw, turned
/// into the matched base.
Eigen::Matrix3d closureInformation(const MatchResult& match, double translation_sigma, double rotation_sigma);

/// Finds where the robot has come back to an old part of the map.
///
/// Candidates are keyframes near the newest one that are not known well relative to it; how far to search follows from
/// the graph's covariance. Where the window is wide, it holds many places that look alike: then the newest path's place
/// in it is found as a lost robot's is. The newest scans are matched as one against the submap there by a correlative
/// search and point-to-line matching. A closure is accepted when most points agree, no other place of the window fits
/// as well, and, where the window is wide or few points agree, a second closure agrees with it, in a wide one from
/// other scans.
class LoopClosureSearch {
 public:
  LoopClosureSearch(const LoopClosureConfig& config, const PlaceSearchConfig& places, const ReferenceConfig& reference,
                    const MatchConfig& match);

  /// @param in_map by keyframe, whether it may be met again
  /// @return edges to add to the graph; empty most of the time
  std::vector<Edge> search(const KeyframeGraph& keyframes, std::span<const char> in_map);

  /// Where a keyframe may have come back to an older one.
  struct Candidate {
    int id;
    Pose2 T_map_newest;  ///< middle of the window
    SearchWindow window;
  };
  /// Matches what led up to a keyframe with the submap around a candidate, which no edge joins to it within
  /// active_sigma.
  /// @return the edge between the two; none where too few points agree, or another place of the window fits as well
  std::optional<Edge> verify(const KeyframeGraph& keyframes, int newest, const Candidate& candidate);

  struct Counters {
    int searches = 0, found = 0, ambiguous = 0, accepted = 0, inconsistent = 0;
  };
  const Counters& counters() const { return counters_; }

 private:
  struct Pending {
    Edge edge;
    double path;  // [m] driven when it was found
  };
  /// The keyframes that are matched against, and what they are drawn from: the next candidate is often the same.
  struct Submap {
    struct Member {
      Pose2 T_map_base;
      std::shared_ptr<const StoredScan> scan;
      friend bool operator==(const Member&, const Member&) = default;
    };
    std::optional<Reference> reference;  // from the first use on
    std::vector<Member> members;
    Eigen::Vector2d centre = Eigen::Vector2d::Zero();  // [m] in map
  };
  /// Draws the submap anew where one of its members has moved, or is another.
  void draw(const KeyframeGraph& keyframes, std::span<const int> ids, const Eigen::Vector2d& centre);
  std::optional<Candidate> candidate(const KeyframeGraph& keyframes, int newest, std::span<const char> in_map);
  std::optional<Candidate> narrow(const KeyframeGraph& keyframes, int newest, const Candidate& wide,
                                  std::span<const char> in_map);
  bool agree(const KeyframeGraph& keyframes, const Edge& a, const Edge& b) const;

  LoopClosureConfig config_;
  PlaceSearchConfig places_config_;
  MatchConfig match_;
  ReferenceConfig submap_config_;
  Submap submap_;
  CorrelativeMatcher matcher_;
  ScanPoints query_;
  NodeSet known_;  // relative to the newest keyframe, each function as it needs it
  struct {
    std::optional<PlaceSearch> search;                 // while the robot is near
    std::vector<int> keyframes;                        // in which it searches, ...
    Eigen::Vector2d centre = Eigen::Vector2d::Zero();  // ... around here
    double searched_at = -1e9;                         // [m] of path_
  } places_;
  std::vector<Pending> pending_;
  double last_overlap_ = 0.0;               // [1] of the last closure found
  double path_ = 0.0, searched_at_ = -1e9;  // [m] driven, and at the last search
  int seen_ = 0;                            // keyframes whose motion is in path_
  Counters counters_;
};

}  // namespace slam
