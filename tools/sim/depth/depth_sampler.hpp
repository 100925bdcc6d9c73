// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <functional>

#include "tools/sim/depth/depth_camera.hpp"

namespace slam::sim {

/// Takes a depth image. @param T_world_base the true pose at the image's stamp
using DepthConsumer = std::function<void(const DepthImage& image, const Pose2& T_world_base)>;

/// The depth camera of a simulation that runs faster than real time: an image every kPeriod, for one consumer.
class DepthSampler {
 public:
  static constexpr int kWidth = 320, kHeight = 240;  ///< [px]
  static constexpr Duration kPeriod = std::chrono::milliseconds(100);

  /// @param consumer may be empty: then nothing is rendered
  DepthSampler(Timestamp start, std::uint64_t seed, DepthConsumer consumer)
      : camera_(kWidth, kHeight, seed), consumer_(std::move(consumer)), next_(start + kPeriod) {}

  /// The world is as at `now`.
  void step(const World& world, const Pose2& T_world_base, Timestamp now) {
    if (!consumer_ || now < next_) return;
    next_ += kPeriod;
    camera_.capture(world, T_world_base, frame_++, now, image_);
    consumer_(image_, T_world_base);
  }

 private:
  DepthCamera camera_;
  DepthConsumer consumer_;
  DepthImage image_;
  Timestamp next_;
  std::uint64_t frame_ = 0;
};

}  // namespace slam::sim
