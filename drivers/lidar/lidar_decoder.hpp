// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <cstddef>
#include <cstdint>
#include <vector>

namespace slam {

/// One sample of a lidar in device units, in the order of acquisition.
struct LidarNode {
  std::uint16_t angle_q6 = 0;     ///< [deg * 64] rises as the head turns, 0..23039
  std::uint32_t distance_q2 = 0;  ///< [mm * 4]; 0: no echo
  std::uint8_t quality = 0;
  bool start = false;  ///< first node of a new turn
};

/// A decoded node and how much younger the newest byte pushed so far is than the node's sampling.
struct TimedNode {
  LidarNode node;
  double age = 0.0;  ///< [s] from sampling to the arrival of the last byte of its packet
};

/// Nodes out of a lidar's stream of bytes, whatever damage it has. Pure; does not allocate after construction if the
/// vector of nodes has room.
class LidarDecoder {
 public:
  virtual ~LidarDecoder() = default;

  /// Takes one byte; appends the nodes it completes, at most mostNodes().
  virtual void push(std::uint8_t byte, std::vector<TimedNode>& nodes) = 0;
  virtual void reset() = 0;
  /// Samples missing before the first node of the last push(), found by the bytes skipped.
  int lost() const { return lost_; }
  /// The turn has ended with the last node of the last push(): the next one need not be waited for.
  bool endsTurn() const { return ends_turn_; }
  virtual std::size_t mostNodes() const = 0;
  virtual std::int64_t rejects() const { return rejects_; }  ///< packets or nodes refused
  /// How often the unit's angle began to count from another zero.
  virtual std::uint32_t zeroShifts() const { return 0; }

 protected:
  int lost_ = 0;
  bool ends_turn_ = false;
  std::int64_t rejects_ = 0;
};

}  // namespace slam
