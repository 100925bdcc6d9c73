// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <string>
#include <vector>

#include "integration/live_faults.hpp"

namespace slam::test {

/// One fault of one device: what it looks like, and what slamd must make of it.
struct Cell {
  const char* fault;
  const char* inject;  ///< lines for slam-sim's fault pipe, after the device's name
  const char* heal;
  const char* words;          ///< that SLAM_HEALTH says of it; empty: nothing can be known of it
  int pose;                   ///< worst localisation state that is right meanwhile
  double error;               ///< [m] from the truth, of a pose that is called localised
  const char* meaning;        ///< for the table: what slamd does
  double notice = 1.1;        ///< [s] that the words may take: a second, and the supervisor's tenth
  int repeats = 0;            ///< how often it comes back
  double seconds = 2.5;       ///< that it lasts behind the words
  int at_least = 0;           ///< the localisation state that must be reached: 2, it must not be trusted silently
  const char* recovery = "";  ///< of the computer: the line in the log when it is over
};
/// Words that name more than a cause: what slamd does meanwhile, and what helps.
inline constexpr const char* kConsequence =
    "(slamd|and) (goes on|tries again|takes|draws|uses|opens)|pose, map and store go on|stamps of messages follow";
inline constexpr const char* kFix =
    "fix: |check |restart |overloaded|set |make room|sudo |plug|stop one|is it broken|nothing is to be "
    "done|measure|exchange|clean|let the "
    "motor|is the camera|see its manual|use slam-replay|take ";
struct Row {
  const char* device;  ///< of slam-sim, and of the table
  const char* status;  ///< name of the device in SLAM_HEALTH; "system": network, clock, disk
  std::vector<Cell> cells;
};

/// Runs a row of the matrix on a slamd that drives.
class FaultMatrix : public LiveFaults {
 public:
  /// Lidar, depth, board, IMU, CAN twice; network, clock, disk.
  static const std::vector<Row>& rows();

 protected:
  void run(const Row& row);

 private:
  void runCell(const Row& row, const Cell& cell);
};

}  // namespace slam::test
