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

/// What can go wrong with an emulated lidar, as LidarEmulator::inject() takes it:
///
/// | kind          | value       | what happens                                                                       |
/// |---------------|-------------|------------------------------------------------------------------------------------|
/// | silent        | 1, 0        | hears nothing, answers nothing, sends nothing; a scan goes on afterwards           |
/// | health        | 0, 1, 2     | OK, warning, error; with 2 (Protection Stop) it does not scan, reset or not        |
/// | stall         | 1, 0        | the motor does not turn: a scan is announced but has no data                       |
/// | lose          | bytes       | missing from the next packets, one from each                                       |
/// | insert        | bytes       | foreign ones in the next packets, one in each                                      |
/// | flip          | bytes       | damaged in the next packet                                                         |
/// | checksum      | packets     | the next ones have a wrong checksum (standard nodes: a wrong check bit)            |
/// | encoder_reset | any         | once: the angle begins at zero again, a capsule tells so by its S bit              |
/// | pause         | ms          | without data; what would have been sampled is missing                              |
/// | turn          | ms          | time of a turn from now on, 50 to 60000: the head all but stands                   |
/// | reboot        | any         | brown-out: the stream breaks off, the boot banner ends 0.67 s later, then idle     |
/// | stale         | bytes       | of an old stream come before the next answer, at most 4096                         |
/// | stuck         | 1, 0        | every turn from the next on is the one before it, bit by bit                       |
/// | unit          | 0, 1, 3     | it is an A1 (firmware 1.29), a C1 or an S3 from its next boot on, which is now     |
/// | other         | 0 to 3      | a lidar of another make is in its place: OtherLidar::Make; 0 puts it back          |
/// | echoes        | 0 to 1      | share of the beams that come back: 0 with the cover on or the laser off; 1: all    |
/// | dust          | 0 to 1      | share of the beams that end at motes within half a metre; 0: none                  |
/// | wrong         | factor      | that ranges are multiplied by, 0.1 to 10; 1 is right                               |
struct LidarFaults {
  bool silent = false, stalled = false, stuck = false;
  int health = 0;
  int lose = 0, insert = 0, flip = 0, checksum = 0;  ///< still to be done
  bool encoder_reset = false, reboot = false;        ///< to be done once
  Duration pause{0};                                 ///< to begin now
  double turn = 0.0;                                 ///< [s] 0: as built
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
