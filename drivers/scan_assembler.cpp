// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/scan_assembler.hpp"

#include <algorithm>
#include <numbers>

#include "core/pose2.hpp"

namespace slam::rplidar {

void ScanAssembler::reset() {
  whole_ = false;
  scan_.size = 0;
}

const LaserScan* ScanAssembler::add(const Node& node, Timestamp stamp) {
  const LaserScan* done = nullptr;
  if (node.start) {
    if (whole_ && scan_.size > 0) {
      finished_.stamp = scan_.stamp;
      finished_.range_min = scan_.range_min;
      finished_.range_max = scan_.range_max;
      finished_.size = scan_.size;
      std::copy_n(scan_.storage.begin(), scan_.size, finished_.storage.begin());
      done = &finished_;
    }
    whole_ = true;
    scan_.size = 0;
  }
  if (!whole_) return nullptr;
  if (scan_.size == 0) scan_.stamp = stamp;
  constexpr double kRadiansPerQ6 = std::numbers::pi / (180.0 * 64.0);
  const Beam beam{.range = static_cast<float>(node.distance_q2) * 0.25e-3F,
                  .bearing = static_cast<float>(wrapAngle(-node.angle_q6 * kRadiansPerQ6)),  // clockwise there
                  .time_offset = static_cast<float>(toSeconds(stamp - scan_.stamp)),
                  .intensity = static_cast<float>(node.quality)};
  if (!scan_.push(beam)) ++overfull_;
  return done;
}

}  // namespace slam::rplidar
