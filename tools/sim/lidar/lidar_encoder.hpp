// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <cstdint>
#include <functional>
#include <vector>

#include "drivers/lidar/codec/rplidar_codec.hpp"

namespace slam::sim {

/// Packs samples as the unit does: it measures at a raw angle, and what it reports lies an offset before that which
/// depends on the distance, because it triangulates.
class LidarEncoder {
 public:
  /// Range [m] at a clockwise angle [deg], 0 without return.
  using Look = std::function<double(double clockwise)>;

  struct Sample {
    double raw = 0.0;     ///< [deg] clockwise
    double offset = 0.0;  ///< [deg] that the reported angle lies before it
    double range = 0.0;   ///< [m]; 0: no echo
    bool start = false;   ///< the first of a turn
  };

  explicit LidarEncoder(rplidar::AnswerType type) : type_(type) {}

  /// Finds the beam that the unit would report at a raw angle [deg].
  Sample take(double raw, bool start, const Look& look);
  /// @param samples of one packet and, for ultra capsules, the first of the next
  /// @param s_bit   of a capsule: the scan begins here, or the encoder was reset
  std::vector<std::uint8_t> pack(const std::vector<Sample>& samples, bool s_bit) const;

 private:
  double offsetFor(double range) const;

  rplidar::AnswerType type_;
  double last_range_ = 4.0;  // [m] a guess for the next one
};

}  // namespace slam::sim
