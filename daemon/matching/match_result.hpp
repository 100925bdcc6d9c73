// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <Eigen/Core>
#include <cstddef>
#include <cstdint>

#include "core/pose2.hpp"

namespace slam {

enum class MatchStatus : std::uint8_t {
  kConverged,       ///< the pose may be fused
  kUnobservable,    ///< converged, but degenerate in 3 - observable directions: there the pose is still the guess
  kIterationLimit,  ///< still moving when the iterations were used up
  kTooFewPairs,     ///< hardly any point met the reference
  kLowOverlap,      ///< converged where too many points contradict the reference: probably a wrong minimum
  kAmbiguous,       ///< another place of the searched window fits as well
};

inline const char* nameOf(MatchStatus status) {
  constexpr const char* kNames[] = {"converged",     "unobservable", "iteration_limit",
                                    "too_few_pairs", "low_overlap",  "ambiguous"};
  return kNames[static_cast<std::size_t>(status)];
}

/// Outcome of any matcher of this folder.
struct MatchResult {
  MatchStatus status = MatchStatus::kIterationLimit;
  Pose2 T_ref_base;                                          ///< last iterate; fuse it only if usable()
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();      ///< of (x, y, theta) in the reference [m, m, rad], within
                                                             ///< the observable directions; zero unless usable()
  Eigen::Matrix3d tension = Eigen::Matrix3d::Zero();         ///< of it, by how the scan's parts contradict each other
  Eigen::Matrix3d directions = Eigen::Matrix3d::Identity();  ///< columns: unit directions, the observable ones first
  int observable = 0;                                        ///< 0..3
  int pairs = 0;                                             ///< points matched at the last iterate
  double overlap = 0.0;      ///< share of the points within overlap_distance of the reference, 0..1
  double known_ratio = 0.0;  ///< share of the points that agree with a surfel seen known_observations times, 0..1
  double residual = 0.0;     ///< [m] RMS distance of those from their lines (point to point: from their points)
  int iterations = 0;

  bool usable() const {
    return status == MatchStatus::kConverged || (status == MatchStatus::kUnobservable && observable > 0);
  }
};

/// The match without what it says of the way along a direction: there the pose stays at the guess, and is blind. What
/// it says across and of the heading stays.
/// @param guess [m] in the reference  @param direction of it, a unit vector
MatchResult projectedOut(const MatchResult& match, const Eigen::Vector2d& guess, const Eigen::Vector2d& direction);

/// How a scan is tracked against the local map.
enum class MatchMethod : std::uint8_t {
  kPointToLine,   ///< matchPointToLine()
  kPointToPoint,  ///< matchPointToPoint(), the paper's baseline
};

/// Settings shared by matchPointToPoint() and matchPointToLine().
struct MatchConfig {
  MatchMethod method = MatchMethod::kPointToLine;  ///< for who tracks scans; searches and closures match to lines
  int max_iterations = 40;
  int min_pairs = 18;                   ///< fewer matched points than this, six for each unknown, is a failure
  double search_translation = 0.0;      ///< [m] how far the guess may be off ...
  double search_rotation = 0.0;         ///< [rad] ... beyond what initial_pair_distance covers
  double initial_pair_distance = 1.00;  ///< [m] gate on the distance of a pair in the first iteration ...
  double final_pair_distance = 0.50;    ///< [m] ... narrowed to this
  double pair_distance_decay = 0.70;    ///< [1] per iteration
  double kernel_scale = 0.05;           ///< [m] residual at which a pair has lost half its weight
  double translation_tolerance = 3e-4;  ///< [m] a step below both tolerances has converged
  double rotation_tolerance = 1e-4;     ///< [rad]
  double point_weight = 0.3;            ///< [1] of a corner point against a point on a wall
  double grazing_observations = 8.0;    ///< [1] where points that may slide were met so often, something stands
  double range_sigma = 0.015;           ///< [m] standard deviation of one lidar range
  double overlap_distance = 0.10;       ///< [m] a point this near to its line agrees with the reference
  double known_observations = 5.0;      ///< [1] a surfel seen so often is known
  double min_overlap = 0.50;            ///< [1] less agreement than this is no match
  double min_information = 0.01;        ///< [1] a direction seen by less than this share of the pairs is blind
  double same_face = 0.2;               ///< cosine: a point and a surfel whose normals differ by more are two faces
  double damping = 0.7;                 ///< [1] per change of the step's direction
  double part_gap = 0.3;                ///< [m] points further apart belong to two parts of a scan ...
  double part_bend = 0.7;               ///< cosine: ... and so do those whose normals differ by more
  double min_confirmed = 0.1;  ///< [1] of a direction's information; along a bare wall noise seldom feigns more

  void visitSettings(auto& v) {
    v.expert(
        "method", method,
        "Scans are matched to lines (plicp) or, as the paper's baseline, to points (icp); searches match to lines.");
    v.expert("max_iterations", max_iterations, "", 1, 1000,
             "A match that has not converged after this many iterations has failed.");
    v.expert("min_pairs", min_pairs, "", 3, 4000, "A match with fewer paired points than this has failed.");
    v.expert("initial_pair_distance", initial_pair_distance, "m", 0.02, 2.0,
             "A point is paired with a line up to this distance in the first iteration.");
    v.expert("final_pair_distance", final_pair_distance, "m", 0.02, 2.0,
             "A point is paired with a line up to this distance in the last iterations.");
    v.expert("kernel_scale", kernel_scale, "m", 0.005, 1.0,
             "A pair with this residual has half the weight of a pair without any.");
    v.expert("point_weight", point_weight, "1", 0.0, 1.0,
             "A point that lies on no line has this share of the weight of a point on a line.");
    v.expert(
        "grazing_observations", grazing_observations, "1", 0.0, 1000.0,
        "A wall point seen at grazing incidence becomes a landmark after this many keyframes have observed it again.");
    v.expert("overlap_distance", overlap_distance, "m", 0.005, 1.0,
             "A point agrees with the local map if it is this near to its line.");
    v.expert("min_overlap", min_overlap, "1", 0.0, 1.0,
             "A match in which a smaller share of the points agrees with the local map has failed.");
    v.expert("min_information", min_information, "1", 0.0, 0.5,
             "A direction that is observed by a smaller share of the pairs than this is not corrected.");
  }
};

}  // namespace slam
