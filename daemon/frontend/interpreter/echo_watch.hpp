// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <algorithm>
#include <cstdint>
#include <optional>

#include "core/scan.hpp"
#include "core/timestamp.hpp"

namespace slam {

struct EchoWatchConfig {
  double few = 0.06, enough = 0.1;                 ///< [1] one echo in twenty is few, with its noise
  Duration mean = std::chrono::milliseconds(600);  ///< over which turns are averaged: few beams scatter
  Duration lasting = std::chrono::seconds(5);      ///< before it is a finding
};

/// Notices a lidar that turns and sends, but sees nothing: the place is wider than its range, the cover is on, its
/// laser is off, its ranges are in another unit than the limits. Which of the first three cannot be seen.
class EchoWatch {
 public:
  enum class Finding : std::uint8_t {
    kNone,
    kNoEcho,  ///< hardly any beam comes back
    kNear,    ///< what comes back is nearer than the lidar can measure
    kFar      ///< or further than it may be
  };

  /// @param limits of the lidar, beside those that the scan has
  void add(const LaserScan& scan, const RangeLimits& limits, Timestamp now) {
    int used = 0, near = 0, far = 0;
    const float least = std::max(scan.range_min, limits.min), most = std::min(scan.range_max, limits.max);
    for (const Beam& beam : scan.beams()) {
      if (beam.range <= 0.0F) continue;
      ++(beam.range < least ? near : beam.range > most ? far : used);
    }
    const int all = std::max(1, scan.size);
    share_ = static_cast<double>(used) / all;
    const double weight = last_ ? std::clamp(toSeconds(now - *last_) / toSeconds(config_.mean), 0.0, 1.0) : 1.0;
    last_ = now;
    mean_ += weight * (share_ - mean_);
    if (mean_ >= (finding_ == Finding::kNone ? config_.few : config_.enough)) {
      blind_since_.reset();
      finding_ = Finding::kNone;
      return;
    }
    if (!blind_since_) blind_since_ = now;
    if (now - *blind_since_ < config_.lasting) return;
    finding_ = 2 * near > all ? Finding::kNear : 2 * far > all ? Finding::kFar : Finding::kNoEcho;
  }

  double share() const { return share_; }  ///< [1] of the beams of the last turn that can be used
  Finding finding() const { return finding_; }

 private:
  EchoWatchConfig config_;
  double share_ = 0.0, mean_ = 0.0;
  std::optional<Timestamp> last_, blind_since_;
  Finding finding_ = Finding::kNone;
};

}  // namespace slam
