// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <optional>
#include <random>
#include <string_view>
#include <vector>

#include "core/timestamp.hpp"

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
/// | stuck         | 1, 0        | every turn repeats the ranges of the first one                                     |
/// | wrong         | factor      | that ranges are multiplied by, 0.1 to 10; 1 is right                               |
struct LidarFaults {
  bool silent = false, stalled = false;
  int health = 0;
  int lose = 0, insert = 0, flip = 0, checksum = 0;  ///< still to be done
  bool encoder_reset = false, reboot = false;        ///< to be done once
  Duration pause{0};                                 ///< to begin now
  double turn = 0.0;                                 ///< [s] 0: as built
  int stale = 0;                                     ///< [bytes]
  double range_factor = 1.0;

  /// @return false for an unknown kind or a value out of its range
  bool inject(std::string_view kind, double value);

  /// Takes note of, or repeats, the range seen at an angle [turns, 0..1).
  double held(double angle, double range);
  /// Does the damage that is due to a packet.
  void damage(std::vector<std::uint8_t>& packet, bool capsule);

 private:
  static constexpr std::size_t kBins = 2880;  // of an eighth of a degree
  bool stuck_ = false;
  std::array<float, kBins> ranges_{};  // of the first turn that is repeated; NaN: not seen yet
  std::mt19937 random_{1};
};

}  // namespace slam::sim
