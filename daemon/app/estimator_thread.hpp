// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <memory>

#include "app/config.hpp"
#include "app/exchange.hpp"
#include "runtime/worker.hpp"
#include "slam/motion_probe.hpp"

namespace slam {

/// Thread *estimator*: drains wheels, IMU and scans into the Localizer and hands out pose and keyframes.
class EstimatorThread {
 public:
  EstimatorThread(const Config& config, Exchange& exchange, std::unique_ptr<Localizer> localizer);
  Worker& worker() { return worker_; }

 private:
  void tick();
  bool addScan(const ReceivedScan& received);

  Exchange& exchange_;
  std::unique_ptr<Localizer> localizer_;
  MotionProbe probe_;
  PoseSnapshot snapshot_;
  std::uint64_t ticks_ = 0, ticks_per_pose_;
  Worker worker_;
};

}  // namespace slam
