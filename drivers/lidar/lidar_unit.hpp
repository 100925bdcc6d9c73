// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <atomic>
#include <cstdint>
#include <string>

#include "drivers/byte_stream.hpp"
#include "drivers/device_status.hpp"
#include "drivers/lidar/lidar_reader.hpp"
#include "drivers/line_device.hpp"

namespace slam {

/// What one make of lidar adds to a SerialLidar: how its scan is begun and ended, and what its silence means. Its calls
/// may wait and allocate.
class LidarUnit {
 public:
  using Clock = LidarReader::Clock;
  virtual ~LidarUnit() = default;

  struct Begun {
    DeviceState state = DeviceState::kStreaming;  ///< any other: it was in vain, and `problem` has the reason
    Problem problem{};                            ///< where it streams, a warning
    bool unanswered = false;                      ///< nobody answered as this unit does: somebody else may be there
    LidarScanStart start{};
    std::string identity{};  ///< in words
  };
  /// Identifies the unit and begins its scan.
  /// @param port   opened; stays until end()
  /// @param others who else may be there: is to forget them once the unit is known
  virtual Begun begin(ByteStream& port, const std::atomic<bool>& cancel, WrongDevice& others) = 0;

  /// A scan has ended in silence, or in bytes without nodes: why.
  virtual Problem silence(const LidarReader& scan) = 0;
  /// Scan and motor off. The port is closed afterwards.
  virtual void end() = 0;
};

}  // namespace slam
