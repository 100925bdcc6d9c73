// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <array>
#include <cstddef>
#include <span>

#include "core/timestamp.hpp"

namespace slam {

/// Accumulated angles of the wheels. Differential: left, right (again left, right with two axles), positive driving
/// forward; others: servo 1.. as the firmware counts.
struct WheelAngles {
  Timestamp stamp;
  std::array<double, 4> angles{};  ///< [rad]
  int count = 2;                   ///< of the angles that are used
  bool restarted = false;          ///< the board began to count anew: no difference to the reading before
  bool lifted = false;             ///< a wheel hangs in the air: what the wheels turn is left out of the angles

  std::span<const double> used() const { return {angles.data(), static_cast<std::size_t>(count)}; }
};

}  // namespace slam
