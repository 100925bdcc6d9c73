// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <Eigen/Core>
#include <cmath>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "relocalisation/distance_field.hpp"

namespace slam {

/// At which rate, by the metre of its way, a beam ends: the decay-rate model of A. Schaefer, L. Luft and W. Burgard,
/// "An analytical lidar sensor model based on ray path information", IEEE RA-L 2(3), 2017. Unlike the distance to the
/// nearest wall alone it does not favour clutter, where a wall is near every beam's end: it asks for the beams that
/// come through as well.
struct BeamModel {
  double sigma = 0.10;             ///< [m] of a wall's place in a map, and ...
  double sigma_per_metre = 0.003;  ///< [1] ... of that relative to the robot
  double rigid_range = 15.0;       ///< [m] around the robot in which a map is bent by no more than that; 0: however far
  double scale_sigma = 0.015;      ///< [1] of a map's scale against the robot's, whose lidar and wheels did not make it
  double stopped = 0.8;            ///< [1] share of the beams that end at a wall of the map, and do not go through it
  double rate_free = 0.03;         ///< [1/m] where the map saw nothing: people, chairs, doors that are closed now
  double rate_unknown = 0.6;     ///< [1/m] where the map has not looked: rooms, of which a beam crosses a metre or two
  double unknown_as_wall = 0.0;  ///< [1] ... and no lower than this share of a wall's rate
  double doorway = 0.1;          ///< [1] of a wall's rate in the gaps of walls: a door may be closed ...
  double doorway_width = 1.2;    ///< [m] ... if the gap is no wider
  double extrapolated_rate = 0.4;  ///< [1] of a wall's rate where a wall of the map would go on beyond the map's rim
  bool stale_free_space = true;    ///< behind a wall that a beam went through the map is too old to say what is free
  double correlation = 0.5;        ///< [m] of wall, all of which the map has or has not: it testifies once
  double surface_layer =
      0.5;  ///< [1] of a wall's thickness: a plan draws a wall too thick, so that a beam may graze it
  double removed_weight = 0.4;  ///< [1] of walls that beams went through: what opened one often opened its neighbour
  double blur_sigmas = 3.0;     ///< [1] of the blur of a wall's place, then it is 0
  double end_sigmas = 2.0;      ///< [1] before its end a beam may be within the wall that it ended at ...
  double roughness = 0.1;       ///< [m] ... and so much more
  double from_lidar = 0.15;     ///< [m] that the robot itself fills
  double at_wall = 2.0;         ///< [1] times the rate of unknown space: a beam that ends at more ended at a wall
  double before_door = 0.5;     ///< [m] that is free before and behind a doorway

  /// [m] of a wall relative to a robot so far away.
  double sigmaAt(double range) const { return std::hypot(sigma, sigma_per_metre * range); }
  /// Of a beam that goes through a wall, negative.
  double logThrough() const { return std::log1p(-stopped); }
};

/// A whole map as beams see it, three bytes and a bit for a cell of its raster. Built once for a map. Allocates.
class DecayRateMap {
 public:
  DecayRateMap(const KeyframeGraph& keyframes, std::span<const int> map, const BeamModel& model = {},
               MapKind kind = MapKind::kScans);

  const DistanceField& walls() const { return walls_; }
  const BeamModel& model() const { return model_; }

  /// log of the rate [1/m] at which a beam of this range [m] ends at a place.
  double logRate(const Eigen::Vector2d& p_map, double range) const;
  double logRateUnknown() const { return std::log(unknown_rate_); }
  /// Mean of it within the map's walls, whose places are known best.
  double logRateWalls() const { return log_rate_walls_; }
  /// Whether such a beam ended at a wall of the map, by all odds.
  bool atWall(double log_rate) const { return log_rate > wall_threshold_; }

  /// What a beam went through: solid cells of the map, each with its share of a wall, counted square to the wall's
  /// face.
  struct Passed {
    std::int64_t cell;
    double log_through;  ///< negative
  };
  /// Appends what lies between the lidar and the end of a beam, as far as it is not the wall that it ended at, nor the
  /// face of one that it did not come through.
  /// @return sum of what was appended
  double pass(const Eigen::Vector2d& from, const Eigen::Vector2d& to, std::vector<Passed>& passed) const;
  /// Log-likelihood of all that beams went through, each cell once. Sorts `passed`.
  double logPassed(std::vector<Passed>& passed) const;

 private:
  std::optional<double> toWall(int column, int row, const Eigen::Vector2d& direction) const;
  bool isDoorway(int column, int row) const;
  bool inSurfaceLayer(int column, int row) const;
  std::vector<float> look();
  std::vector<std::uint8_t> blurred(const std::vector<float>& wall, double sigma) const;
  double meanOfWalls(const std::vector<std::uint8_t>& level) const;
  std::size_t levelOf(double range) const;

  DistanceField walls_;
  BeamModel model_;
  double wall_rate_ = 0.0;     // [1/m] within a wall
  double unknown_rate_ = 0.0;  // [1/m]
  double log_rate_walls_ = 0.0;
  double wall_threshold_ = 0.0;
  std::vector<std::vector<std::uint8_t>> levels_;  // log rates, of a wall known to sigma times 1, 2, 4, ...
  std::vector<bool> surface_layer_;                // of a wall, by cell
  std::vector<double> coarser_;                    // [m] ranges from where the next level is the nearer one
};

}  // namespace slam
