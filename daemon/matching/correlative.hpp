// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <numbers>
#include <span>
#include <vector>

#include "matching/match_result.hpp"
#include "matching/reference.hpp"
#include "matching/scan_points.hpp"

namespace slam {

/// Where the truth is looked for around a guess.
struct SearchWindow {
  double translation = 0.5;  ///< [m] on either side of the guess, in x and in y
  double rotation = 0.8;     ///< [rad] on either side

  void visitSettings(auto& v) {
    v.expert("translation", translation, "m", 0.0, 20.0,
             "The search begins with a window of this half width around the prediction and grows with each further "
             "failure.");
    v.expert("rotation", rotation, "rad", 0.0, std::numbers::pi,
             "The search begins with a window of this half angle around the prediction and grows with each further "
             "failure.");
  }
};

struct CorrelativeConfig {
  double translation_step = 0.25;  ///< [m] between hypotheses; the turn step moves a point at mean range as far
  double kernel_scale = 0.35;      ///< [m] a point this far from the reference no longer counts
  int max_points = 90;             ///< of the scan, evenly spaced in acquisition order
  int max_hypotheses = 1 << 13;    ///< a wider window is searched in larger steps
  int refined = 8;                ///< best hypotheses, each a local maximum, that are refined by point-to-line matching
  double trusted_overlap = 0.70;  ///< [1] a direct match that agrees with so much is not searched again
  double ambiguity = 0.95;        ///< [1] a second place whose overlap reaches this share of the best's is ambiguous
  double distinct_distance = 0.50;  ///< [m] results further apart than this ...
  double distinct_rotation = 0.35;  ///< [rad] ... or this are two places
  double reach = 1.5;               ///< [1] of a step: half of it in both directions, and by the turn
  double mostly_translation = 0.5;  ///< [1] of a unit direction: the rest is rotation
  double same_overlap = 0.02;       ///< [1] less is no difference
  double slide_step = 0.05;         ///< [m] along a degenerate direction
  double slide_kernel = 0.15;       ///< [m] of the score along it
  float clear_gain = 0.02F;         ///< [1] of the score that sliding must bring

  void visitSettings(auto& v) {
    v.expert("ambiguity", ambiguity, "1", 0.0, 1.0,
             "A search has no result when its second-best place has more than this share of the best one's score.");
  }
};

/// Outcome of a search: the best match, and how good the second best place is beside it.
struct SearchResult {
  MatchResult match;       ///< kAmbiguous when the second place is as good
  double runner_up = 0.0;  ///< [1] overlap of the second place / overlap of the best, 0 without a second
};

/// Finds a scan in the reference without a good guess: scores every pose of a window by how near the scan's points
/// come to the reference [Olson 2009], and refines the best ones by matchPointToLine().
///
/// Keeps its scratch memory: after construction nothing allocates. Not safe for concurrent use.
/// [Olson 2009] E. Olson, "Real-time correlative scan matching", Proc. ICRA 2009.
class CorrelativeMatcher {
 public:
  explicit CorrelativeMatcher(const CorrelativeConfig& config = {});

  /// @param guess first T_ref_base, the middle of the window
  /// @return      never throws; status as of matchPointToLine(), or kAmbiguous. Along a degenerate direction, which
  /// stays
  ///              unclaimed, the pose is the window's place where most points come near the reference
  SearchResult match(const Reference& reference, std::span<const ScanPoint> points, const Pose2& guess,
                     const SearchWindow& window, const MatchConfig& config) noexcept;

  /// matchPointToLine() from the guess, and match() only where that fails or agrees with little of the reference.
  SearchResult matchOrSearch(const Reference& reference, std::span<const ScanPoint> points, const Pose2& guess,
                             const SearchWindow& window, const MatchConfig& config) noexcept;

 private:
  struct Hypothesis {
    Pose2 T_ref_base;
    float score;  // [1] per point, 0..1
    int turn, column, row;
  };

  void sample(std::span<const ScanPoint> points);
  /// @return [m] between two hypotheses
  double scoreAll(const Reference& reference, const Pose2& guess, const SearchWindow& window, double lever);
  float score(const Reference& reference, const Eigen::Vector2d& translation, double kernel) const;
  void slide(const Reference& reference, double reach, MatchResult& match);
  void keepBest(const Hypothesis& hypothesis);

  CorrelativeConfig config_;
  std::vector<Eigen::Vector2d> sample_, rotated_;  // [m] the scan's points in base, and turned
  std::vector<Hypothesis> best_;                   // sorted, best first
};

}  // namespace slam
