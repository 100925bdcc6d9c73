// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <algorithm>
#include <cstdint>
#include <optional>
#include <random>
#include <string_view>
#include <vector>

#include "core/timestamp.hpp"
#include "tools/sim/lidar/lidar_identity.hpp"

namespace slam::sim {

/// What can go wrong with an emulated lidar.
struct LidarFaults {
  bool silent = false, stalled = false, stuck = false;
  int health = 0;
  int lose = 0, insert = 0, flip = 0, checksum = 0;  ///< still to be done
  bool encoder_reset = false, reboot = false;        ///< to be done once
  Duration pause{0};                                 ///< to begin now
  Duration turn{0};                                  ///< 0: as built
  int stale = 0;                                     ///< [bytes]
  double range_factor = 1.0;
  double echoes = 1.0, dust = 0.0;      ///< [1] of the beams
  std::optional<LidarIdentity> unit{};  ///< to become now
  int other = 0;                        ///< OtherLidar::Make

  /// @return false for an unknown kind or a value out of its range
  bool inject(std::string_view kind, double value);

  /// What becomes of one beam: it ends at a mote, or does not come back.
  struct Fate {
    double mote = 0.0;  ///< [m] 0: there is none
    bool lost = false;
    double of(double range) const {
      if (mote > 0.0) return range > 0.0 ? std::min(range, mote) : mote;
      return lost ? 0.0 : range;
    }
  };
  Fate nextFate();
  /// Does the damage that is due to a packet.
  void damage(std::vector<std::uint8_t>& packet, bool capsule);

 private:
  std::mt19937 random_{1};
};

}  // namespace slam::sim
