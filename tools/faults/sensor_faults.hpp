// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <numbers>
#include <optional>
#include <random>
#include <vector>

#include "core/pose2.hpp"
#include "core/pose_history.hpp"
#include "core/samples.hpp"
#include "core/scan.hpp"

namespace slam {

/// What an IMU, or the node that reads it, does wrong.
struct ImuFault {
  double offset = 0.0;                                    ///< [rad/s] about the vertical
  double clip = std::numeric_limits<double>::infinity();  ///< [rad/s] largest rate that is reported
  double step = 0.0;                                      ///< [rad/s] of the values; 0: as fine as the sensor's
  bool degrees = false;                                   ///< values in deg/s
  bool down = false;                                      ///< mounted upside down, about its x axis

  ImuSample apply(ImuSample sample) const {
    if (offset != 0.0) sample.gyro.z() += offset;  // -0.0 stays
    if (down) {
      for (const int axis : {1, 2}) {
        sample.gyro[axis] = -sample.gyro[axis];
        sample.accel[axis] = -sample.accel[axis];
      }
    }
    for (double& rate : sample.gyro) {
      rate = std::clamp(rate, -clip, clip);
      if (step > 0.0) rate = step * std::round(rate / step);
      if (degrees) rate *= 180.0 / std::numbers::pi;
    }
    return sample;
  }
};

/// How a lidar is mounted wrong.
struct LidarMountFault {
  bool upside_down = false;
  bool turned = false;  ///< by 180 degrees

  void apply(LaserScan& scan) const;
};

/// What wheels report wrong.
struct WheelFault {
  int jumps = 0;                  ///< sudden false motions at random times
  double jump_translation = 0.5;  ///< [m] of a jump, at most, in x and in y
  double jump_rotation = 0.785;   ///< [rad] of a jump, at most
  double noise = 0.0;             ///< [m per sqrt(m)] on distance, [rad per sqrt(m), rad per sqrt(rad)] on heading
  double distance_scale = 0.0;    ///< [1] error of the wheels' radius
  bool reverse_sign = false;      ///< driving backwards is reported as forwards
  double lag = 0.0;               ///< [s] a sample holds where the wheels stood so long before its stamp
  bool swapped = false;           ///< left and right: the wheels turn the wrong way
  bool backwards = false;         ///< both count backwards
};

/// Turns the wheels' recorded dead reckoning into the faulty one, increment by increment.
class FaultyWheels {
 public:
  /// @param first, last [us] of the drive, between which jumps are drawn
  FaultyWheels(const WheelFault& fault, std::uint64_t seed, std::int64_t first, std::int64_t last);

  WheelSample apply(WheelSample recorded);

 private:
  WheelFault fault_;
  std::mt19937_64 random_;
  std::normal_distribution<double> normal_;
  std::uniform_real_distribution<double> uniform_{-1.0, 1.0};
  std::vector<std::int64_t> jumps_;
  std::size_t next_jump_ = 0;
  PoseHistory history_{4096};
  std::optional<Pose2> last_;
  Pose2 pose_;
};

}  // namespace slam
