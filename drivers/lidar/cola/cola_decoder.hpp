// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "drivers/lidar/codec/cola_codec.hpp"
#include "drivers/lidar/lidar_decoder.hpp"

namespace slam {

/// Scans out of telegrams of CoLa A. One that measures other beams than the first, or has a number that is none, is
/// left out whole. How many are missing is known by the unit's clock.
class ColaDecoder final : public LidarDecoder {
 public:
  /// @param scan that the unit has sent: the others are like it. @param byte_time [s] on the line
  ColaDecoder(const cola::Scan& scan, double byte_time);

  void push(std::uint8_t byte, std::vector<TimedNode>& nodes) override;
  void reset() override;
  std::size_t mostNodes() const override { return static_cast<std::size_t>(scan_.beams); }

 private:
  bool takeScan(std::vector<TimedNode>& nodes);

  cola::Scan scan_;
  double byte_time_;
  std::string text_;
  bool inside_ = false;  // a telegram
  std::vector<std::uint32_t> distances_q2_;
  std::optional<std::uint32_t> last_began_;  // [us] of the last scan given
};

}  // namespace slam
