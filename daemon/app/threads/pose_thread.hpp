// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <cstdint>
#include <vector>

#include "app/channels.hpp"
#include "config/config.hpp"
#include "runtime/clock.hpp"
#include "runtime/worker.hpp"

namespace slam {

/// Thread *pose*: publishes odometry and pose as soon as the estimator tells them, in real time, and nothing else. What
/// was sent goes to the bus thread, which records it.
class PoseThread {
 public:
  /// @param sender that the bus thread opens
  PoseThread(const Config& config, const PoseEnds& ends, const WallClock& clock, LcmSender& sender);
  Worker& worker() { return worker_; }

 private:
  void tick();

  const PoseEnds ends_;
  const WallClock& clock_;
  LcmSender& sender_;
  PoseSnapshot snapshot_;
  LcmSender::Outcome outcome_;  // of the last message
  std::int64_t scans_published_ = 0;
  std::vector<std::uint8_t> buffer_;
  Worker worker_;
};

}  // namespace slam
