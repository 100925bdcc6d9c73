// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <algorithm>
#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "relocalisation/decay_rate_map.hpp"
#include "relocalisation/place_fit.hpp"
#include "relocalisation/place_search.hpp"

namespace slam {

struct MapRegistrationConfig {
  PlaceSearchConfig places = {};  ///< as for a lost robot
  double stretch = 2.0;           ///< [m] of the second map's path are compared as one: short enough to be rigid
  double longest_step = 2.0;      ///< [m] between keyframes in a row; where it is more, another drive begins
  int most_stretches = 60;        ///< that are searched for; of a longer path there is more between them
  int most_hypotheses = 40;       ///< of the whole second map that are compared
  double same_distance = 0.30;    ///< [m] two hypotheses that put most stretches nearer to each other than this ...
  double same_rotation = 0.10;    ///< [rad] ... and turned by less are one
  double bend = 0.02;             ///< [1] of the way between two stretches, by which the maps may be bent differently
  double min_agreement = 0.5;     ///< [1] of what ends in known space ends at walls and looks through none, ...
  double min_likelihood = 0.6;    ///< [1] ... and so much of the log-likelihood that it has where nothing changed
  int min_found = 2;              ///< stretches that are each found by themselves, and at one place of the second map
  double min_found_share = 0.2;   ///< [1] of the stretches that lie in known space are
  double max_elsewhere = 0.2;     ///< [1] of the stretches that are found may be found where the others are not
  double min_margin = 16.0;       ///< of the log-likelihood over that of any other hypothesis ...
  double min_margin_share = 0.2;  ///< [1] ... and that share of it, as most of both is the same walls
  double min_overlap = 0.5;  ///< [1] of the second map in known space, below which no place of two is one that fits
};

/// How what was seen from some keyframes agrees with a place in a map.
struct PlaceAgreement {
  Pose2 T_map_newest;           ///< where it fits best
  double log_likelihood = 0.0;  ///< over that of the same beams in unmapped space
  int walls = 0, contradicted = 0,
      unknown = 0;  ///< [rays] that end at a wall; in free space or behind a wall; unmapped

  int known() const { return walls + contradicted; }
  double share() const { return static_cast<double>(walls) / std::max(1, known()); }
  double overlap() const { return static_cast<double>(known()) / std::max(1, known() + unknown); }
};

/// Keyframes of the second map in a row.
struct Stretch {
  int run, oldest, newest;  ///< keyframes: the first one of the drive, and those that are compared
};

/// Where a map lies in another one, and how surely.
struct RegisteredMap {
  enum class Outcome : std::uint8_t { kFound, kNowhere, kAmbiguous, kContradictory };
  struct Found {
    int keyframe;
    Pose2 T_map_keyframe;  ///< as searched for by itself
  };
  Outcome outcome = Outcome::kNowhere;
  Pose2 T_map_second = {};        ///< frame of the second map in that of the first
  Pose2 T_map_other = {};         ///< kAmbiguous, kContradictory: the other place
  int stretches = 0;              ///< that were searched for
  std::vector<Found> found = {};  ///< of these, at this place of the second map
  int elsewhere = 0;              ///< of these, at another one
  double agreement = 0.0;         ///< [1] of what the second map shows of the first one's space agrees with it
  double overlap = 0.0;           ///< [1] of what the second map shows lies in the first one's space
  double margin = 0.0;            ///< of the log-likelihood over any other place's, or over that of none ...
  double needed = 0.0;            ///< ... and what is enough
};

/// Finds a map in another one. Each stretch of its path is searched for as a lost robot is, by itself; where the
/// searches put the whole map are hypotheses, each of which is evaluated by what all stretches saw. The likeliest one
/// is taken if enough stretches were found there by themselves, if hardly any was found elsewhere, if most of what it
/// shows of the first map's space agrees with it, and if no other hypothesis is nearly as likely.
class MapRegistration {
 public:
  /// @param map, second ids of the keyframes of both maps; the poses of the second one are in its own frame
  /// @param progress is called with the share [1] that is done
  MapRegistration(const KeyframeGraph& keyframes, std::span<const int> map, std::span<const int> second,
                  const MapRegistrationConfig& config = {});
  RegisteredMap find(const std::function<void(double)>& progress = {});

  /// What a stretch saw, laid at a place.
  PlaceAgreement agreement(const Stretch& stretch, const Pose2& T_map_newest) const;
  const std::vector<Stretch>& stretches() const { return stretches_; }

 private:
  struct Hypothesis {
    Pose2 T_map_second;
    PlaceAgreement all = {};              // sums
    std::vector<PlaceAgreement> at = {};  // by stretch
  };
  double expected(const PlaceAgreement& all) const;
  void divide(std::span<const int> second);
  bool near(const Pose2& T_map_a, const Pose2& T_map_b, double way) const;
  bool same(const Hypothesis& a, const Hypothesis& b) const;
  Hypothesis evaluated(const Pose2& T_map_second) const;
  std::vector<Pose2> search(const std::function<void(double)>& progress);
  std::vector<Hypothesis> compare(std::span<const Pose2> candidates, const std::function<void(double)>& progress) const;
  void count(const Hypothesis& best, RegisteredMap& result) const;

  const KeyframeGraph& keyframes_;
  MapRegistrationConfig config_;
  PlaceSearch places_;
  std::vector<Stretch> stretches_;
  std::vector<RegisteredMap::Found> found_;  // wherever
};

}  // namespace slam
