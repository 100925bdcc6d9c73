// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <memory>

#include "app/channels.hpp"
#include "config/config.hpp"
#include "diagnostics/motion_probe.hpp"
#include "frontend/front_end.hpp"
#include "frontend/interpreter/echo_watch.hpp"
#include "runtime/worker.hpp"

namespace slam {

/// Thread *estimator*: drains wheels, IMU and scans into the FrontEnd and hands out pose and keyframes, at its rate and
/// as soon as a scan has come.
class EstimatorThread {
 public:
  EstimatorThread(const Config& config, const EstimatorEnds& ends, std::unique_ptr<FrontEnd> front_end);
  Worker& worker() { return worker_; }

 private:
  void tick();
  void handOverPose();
  void takeIn();  ///< all that has come
  bool addScan(const ReceivedScan& received);

  const EstimatorEnds ends_;
  std::unique_ptr<FrontEnd> front_end_;
  MotionProbe probe_;
  EchoWatch echoes_;
  PoseSnapshot snapshot_;
  std::uint64_t ticks_ = 0, ticks_per_pose_;
  bool scanned_ = false;  // since the pose was told
  Worker worker_;
};

}  // namespace slam
