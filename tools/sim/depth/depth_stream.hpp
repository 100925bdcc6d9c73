// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <cstdint>
#include <deque>
#include <functional>
#include <optional>
#include <vector>

#include "tools/sim/depth/depth_camera.hpp"
#include "tools/sim/depth/depth_wire.hpp"

namespace slam::sim {

/// What a camera needs to know of an instant.
struct DepthViewpoint {
  Pose2 T_world_base;
  double drive_time = 0.0;  ///< [s] for World::setTime()
};

/// A running depth camera: captures when its own clock says so, and hands frames out as late as the device does. Pure:
/// time and viewpoints come from outside.
class DepthStream {
 public:
  /// @return viewpoint at an instant, std::nullopt while the simulation has not got there
  using Viewpoint = std::function<std::optional<DepthViewpoint>(Timestamp)>;

  static constexpr double kMaxDrift = 50e-6;                            ///< [1] of the camera's clock
  static constexpr Duration kMinDelay = std::chrono::milliseconds(15);  ///< from the capture to the wire ...
  static constexpr Duration kMaxDelay = std::chrono::milliseconds(25);  ///< ... and at most

  DepthStream(const World& world, const DepthMode& mode, std::uint64_t seed, Timestamp start, Viewpoint viewpoint);

  /// Captures the frame that is due, if one is. Call it at next() at the latest: frames that are missed are lost.
  void capture(Timestamp now);
  /// Header and pixels of the oldest frame whose delay is over; empty: there is none.
  std::vector<std::uint8_t> take(Timestamp now);
  /// When there is something to do again.
  Timestamp next() const;

  /// True time of a frame's capture. @param frame index, from 1
  Timestamp captureTime(std::uint32_t frame) const;
  const DepthCamera& camera() const { return camera_; }

 private:
  static constexpr Duration kLag = std::chrono::milliseconds(6);    ///< until the simulation has the pose
  static constexpr Duration kRetry = std::chrono::milliseconds(2);  ///< where it has not
  static constexpr std::size_t kPending = 3;                        ///< frames that the device holds at most

  struct Frame {
    Timestamp due;
    std::vector<std::uint8_t> bytes;
  };

  std::uint64_t deviceTime(std::uint32_t frame) const;  // [us]
  Frame encode(Timestamp captured) const;

  World world_;
  DepthMode mode_;
  std::uint64_t seed_;
  Timestamp start_, retry_ = Timestamp::min();
  Viewpoint viewpoint_;
  DepthCamera camera_;
  double drift_;  // [1] the camera's clock runs faster by this share
  std::uint32_t frame_ = 1;
  DepthImage image_;
  std::deque<Frame> waiting_;
};

}  // namespace slam::sim
