// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <cstdint>
#include <deque>
#include <numbers>
#include <optional>
#include <span>
#include <vector>

#include "graph/keyframe_graph.hpp"
#include "matching/scan_points.hpp"
#include "relocalisation/decay_rate_map.hpp"
#include "relocalisation/global_search.hpp"
#include "relocalisation/place_fit.hpp"

namespace slam {

/// What a kind of map says of a place, and how surely.
struct PlaceModel {
  MapKind kind = MapKind::kFloorPlan;
  BeamModel beams;
  double unchanged = 0.45;     ///< [1] of what a session sees in the map's own building stands where it was mapped
  double margin_share = 0.75;  ///< [1] of min_margin: the less sharp its walls, the smaller a margin can be
  int neighbours = 3;          ///< best places that are compared with those beside them, too
};
PlaceModel floorPlanModel();
/// Scans know a wall's place better than a building's plan does, have the lidar's scale and draw no wall too thick.
PlaceModel scanMapModel();

struct PlaceSearchConfig {
  GlobalSearchConfig search;
  double query_length = 8.0;    ///< [m] of the newest path are searched for as one scan
  int max_query_points = 1440;  ///< of it
  int max_search_points = 240;  ///< of it are searched for, as many along the walls as across them
  double max_range = 40.0;      ///< [m] points further from the robot are left out: the map is too coarse for them
  double min_score = 0.35;      ///< [1] of the search
  int places = 120;             ///< best places of the search that are compared ...
  double place_share = 0.7;     ///< [1] ... if they reach such a share of the best one's score
  PlaceModel model = scanMapModel();  ///< of the map, that they are compared by
  double neighbour_step = 0.7;        ///< [m] to each side lie neighbours of a place, and twice as far
  double part_length = 2.0;           ///< [m] of path that fits the map as it is
  int searches = 4;                   ///< newest ones whose log-likelihoods are averaged, at most
  int contenders = 10;                ///< best places that are judged by all of them
  double min_margin = 8.0;      ///< of the best place's log-likelihood over any other's, in the mean of many searches;
                                ///< in n of them 1 + 1/n times as much
  double same_distance = 0.75;  ///< [m] results nearer than this ...
  double same_rotation = 0.2;   ///< [rad] ... are one place
  double against_gyro = 120.0;  ///< log-likelihood that a place lacks whose heading the gyro contradicts
  int scaled_places = 30;       ///< best places that are fitted in other scales, too
  std::int64_t fit_work = 300;  ///< [points] of the search that take as long as to fit a ray of a place
  PlaceFitConfig fit;           ///< of the places that are compared

  void visitSettings(auto& v) {
    v.expert("searches", searches, "1", 1, 100,
             "A place is judged by the mean log-likelihood of this many newest searches at most.");
    v.expert("min_margin", min_margin, "1", 1.0, 1000.0,
             "The best place must exceed any other by this mean log-likelihood; fewer searches need more, floor "
             "plans three quarters.");
  }
};

/// Finds the place of a session in a map: what was seen along its newest path is searched for, the places found are
/// compared by the likelihood of all beams, and the best one is believed when it leads all others clearly, or less
/// clearly but in several searches. Where places look alike it says nothing.
///
/// A search may be spread over several calls. Until it is done nothing is said, and one that had to leave out places
/// for want of memory says of none that it is the only one.
///
/// Without a window, one contender is that the session is in no place of the map. The log-likelihood of a session's
/// place is expected to be about what walls mapped there give its rays, and that of a wrong place what the best wrong
/// place of the map gives them. With the same spread about both, either is as likely half-way between them.
///
/// Points are drawn from walls of all directions alike (normal-space sampling), so that the few that tell one place of
/// a corridor from the next weigh as much as the many that do not. [Rusinkiewicz 2001] S. Rusinkiewicz and M. Levoy,
/// "Efficient variants of the ICP algorithm", Proc. 3DIM 2001.
class PlaceSearch {
 public:
  explicit PlaceSearch(const PlaceSearchConfig& config = {});

  /// Begins a new session, to be looked for among the keyframes `map`.
  void begin(const KeyframeGraph& keyframes, std::span<const int> map);
  /// The map stays, the session is another one.
  void begin();
  bool hasMap() const { return global_.has_value(); }
  /// Whether a search waits to go on.
  bool underWay() const { return under_way_.has_value(); }

  enum class Outcome : std::uint8_t { kFound, kAmbiguous, kElsewhere, kUnfinished };
  struct Result {
    Outcome outcome = Outcome::kElsewhere;  ///< kElsewhere: none of the map is likelier; kUnfinished: call again
    Pose2 T_map_newest;                     ///< best place, if any is found
    double margin =
        0.0;  ///< of its log-likelihood over any other's and that of none, as if in the mean of many searches
    double needed = 0.0;                   ///< margin from which on it is believed
    std::vector<Pose2> T_map_rivals = {};  ///< other places of which it does not lead by as much
  };
  /// @param oldest first keyframe of the session
  /// @param around the robot is in this window; none: anywhere, in the map or not
  /// @param heading_tolerance [rad] by which the session's heading may be off in the map, by the gyro; pi: nothing
  /// is known
  /// @param work [points] that may be compared with the map, less what was: below zero by the fits of one search at
  /// most. A search under way goes on, whatever is asked for. nullptr: as many as it takes
  Result search(const KeyframeGraph& keyframes, int oldest, int newest, const std::optional<PlaceWindow>& around = {},
                double heading_tolerance = std::numbers::pi, std::int64_t* work = nullptr);

  bool same(const Pose2& a, const Pose2& b) const;
  /// Where the best places of the newest search put the session's frame in the map, likeliest first.
  std::span<const Pose2> contenders() const { return T_map_sessions_; }
  /// The map that begin() was given, as beams see it. @pre hasMap()
  const DecayRateMap& field() const { return *field_; }

 private:
  /// What a search compared places by.
  struct Look {
    QueryCloud view;
    Pose2 T_session_newest;
    double heading_tolerance;  // [rad] of it
  };
  struct UnderWay {
    GlobalSearch::Search search;
    std::optional<PlaceWindow> around;
  };
  void ask(const KeyframeGraph& keyframes, int oldest, int newest, const std::optional<PlaceWindow>& around,
           double heading_tolerance);
  void sampleDirections();
  std::vector<PlaceFit> candidates(const UnderWay& done);
  PlaceFit fit(const Look& look, const Pose2& T_map_newest, double scale);
  std::vector<PlaceFit> fitScale(std::vector<PlaceFit> places);
  std::vector<PlaceFit> fitBeside(std::vector<PlaceFit> places, const std::optional<PlaceWindow>& around);
  std::vector<PlaceFit> each(std::vector<PlaceFit> places) const;
  Result leader(std::span<const PlaceFit> places, bool in_window);
  struct Expected {
    double own = 0.0, unmapped = 0.0;  // log-likelihood
  };
  Expected expected(const QueryCloud& view) const;

  PlaceSearchConfig config_;
  std::optional<GlobalSearch> global_;
  std::optional<DecayRateMap> field_;
  std::deque<Look> looks_;             // of this session, newest first
  std::optional<UnderWay> under_way_;  // for the newest look
  std::int64_t fitted_rays_ = 0;
  std::vector<Pose2> T_map_sessions_;  // where the newest search's best places put it
  ScanPoints query_;
  std::vector<Eigen::Vector2d> sample_;  // [m] of the query, as many points of each direction
};

}  // namespace slam
