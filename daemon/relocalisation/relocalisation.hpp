// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <algorithm>
#include <cstdint>
#include <memory>
#include <numbers>
#include <optional>
#include <span>
#include <vector>

#include "graph/keyframe_graph.hpp"
#include "matching/correlative.hpp"
#include "matching/reference.hpp"
#include "relocalisation/floor_atlas.hpp"
#include "relocalisation/place_search.hpp"

namespace slam {

struct RelocalisationConfig {
  PlaceSearchConfig places;
  double interval = 0.5;  ///< [m] of path between two searches
  /// A search is bounded by [points] compared with the map, 150 to 300 million in a second of a core: at one keyframe
  /// that many, then it goes on at the next one ...
  std::int64_t work_at_once = 100'000'000;
  /// ... of those that each scan used brings, so that a lost robot needs no more time than its other scans do ...
  std::int64_t work_per_scan = 500'000;
  std::int64_t work_saved = 250'000'000;  ///< ... and which are saved up to here
  double submap_radius = 40.0;            ///< [m] of the map around a place are matched against
  double min_overlap = 0.55;  ///< [1] of the points agree with the map where they were found, or a person placed them
  int max_iterations = 200;   ///< of the match: to blurred walls it creeps, and no pose waits for it
  double floor_gap = 40.0;    ///< [m] between maps that are searched together: no scan reaches from one to the other
  double submap_extent = 102.4;  ///< [m] side of the square that is matched against

  void visitSettings(auto& v) {
    v.expert("min_overlap", min_overlap, "1", 0.1, 1.0,
             "A place in the map, found or given by a person, is accepted if this share of the points agrees with it.");
    places.visitSettings(v);
  }
};

/// Finds a robot that does not know where it is in a map: the session that it has mapped since is searched for in the
/// whole map, and matched to it where it was found.
class Relocalisation {
 public:
  Relocalisation(const RelocalisationConfig& config, const ReferenceConfig& reference, const MatchConfig& match);

  /// Begins a new session, to be looked for among the keyframes `map`.
  void begin(const KeyframeGraph& keyframes, std::span<const int> map);
  /// ... among the keyframes of several maps.
  void begin(std::shared_ptr<const FloorAtlas> atlas);
  /// The map stays, the session is another one.
  void begin();

  struct Found {
    Pose2 T_map_newest;
    MatchResult match;
  };
  /// @param oldest first keyframe of the session
  /// @param heading_tolerance [rad] by which its heading may be off in the map, by the gyro; pi: nothing is known
  /// @return what was found at this keyframe, if it was searched for at all and is believed
  std::optional<Found> search(const KeyframeGraph& keyframes, int oldest, int newest,
                              double heading_tolerance = std::numbers::pi);
  /// So many scans were used since this was called the last time.
  void allowFor(std::int64_t scans) { work_ = std::min(config_.work_saved, work_ + scans * config_.work_per_scan); }
  /// Whether a search waits to go on.
  bool underWay() const { return places_.underWay(); }

  /// Looks around the pose of `newest` only, which a person gave.
  std::optional<Found> searchNear(const KeyframeGraph& keyframes, int oldest, int newest, const SearchWindow& window);

  struct Counters {
    int searches = 0, found = 0, ambiguous = 0, refused = 0, interrupted = 0;
  };
  const Counters& counters() const { return counters_; }
  /// Whether two poses are one place.
  bool same(const Pose2& a, const Pose2& b) const { return places_.same(a, b); }
  /// What the newest search over the whole map found.
  const PlaceSearch::Result& newest() const { return newest_; }

 private:
  void gather(const KeyframeGraph& keyframes, int oldest, int newest);
  void buildSubmap(const KeyframeGraph& keyframes, const Eigen::Vector2d& centre);
  void beginIn(const KeyframeGraph& keyframes, std::span<const int> map);

  RelocalisationConfig config_;
  MatchConfig match_;
  PlaceSearch places_;
  ReferenceConfig submap_config_;
  std::optional<Reference> submap_;  // from the first use on
  CorrelativeMatcher matcher_;
  std::int64_t work_;                        // [points] that may be compared now
  std::shared_ptr<const FloorAtlas> atlas_;  // whose keyframes are the map's; nullptr: those that a search is given
  std::vector<char> in_map_;                 // by keyframe
  ScanPoints query_;
  double path_ = 0.0, searched_at_ = -1e9;  // [m]
  int seen_ = -1;                           // keyframe that path_ ends at
  Counters counters_;
  PlaceSearch::Result newest_;
};

}  // namespace slam
