// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <cstdint>
#include <functional>
#include <vector>

#include "core/timestamp.hpp"

namespace slam::sim {

/// A lidar of another make at byte level: it sends unasked and hears nothing.
class OtherLidar {
 public:
  enum Make : std::uint8_t {
    kNone,
    kLdrobot,  ///< LD06, LD19: packets of 47 bytes that begin with 54 2C
    kYdlidar,  ///< X4 and its like: AA 55, a count, the samples
    kNeato,    ///< XV-11, LDS-01: 22 bytes that begin with FA and a number from A0 to F9
  };
  /// Range [m] at a bearing [rad, counter-clockwise], 0 without return.
  using Look = std::function<double(double bearing)>;

  /// Appends the packets that are due by `now`.
  void stream(Make make, Timestamp now, const Look& look, std::vector<std::uint8_t>& out);

 private:
  Timestamp next_{};
  double angle_ = 0.0;  // [deg] clockwise
};

}  // namespace slam::sim
