// SPDX-License-Identifier: BSD-3-Clause
#include "app/estimator_thread.hpp"

#include "app/device_configs.hpp"
#include "runtime/clock.hpp"

namespace slam {
namespace {

const Eigen::Vector3d kSetPoseSigma(0.2, 0.2, 0.1);  // [m, m, rad] of a pose given by a person

}  // namespace

EstimatorThread::EstimatorThread(const Config& config, Exchange& exchange, std::unique_ptr<Localizer> localizer)
    : exchange_(exchange),
      localizer_(std::move(localizer)),
      probe_(config.localizer),
      ticks_per_pose_(ticksPerPose(config)),
      worker_(estimatorWorker(config), [this] { tick(); }) {
  snapshot_.map_id = localizer_->mapId();
}

void EstimatorThread::tick() {
  exchange_.localizers.popOne([this](Localizer* fresh) {
    exchange_.used_localizers.tryPush(localizer_.release());
    localizer_.reset(fresh);
    snapshot_.map_id = fresh->mapId();
  });
  exchange_.corrections.popOne([this](MapCorrection* correction) {
    if (correction->map_id == snapshot_.map_id) localizer_->apply(*correction);
    exchange_.used_corrections.tryPush(correction);
  });
  exchange_.set_poses.drain([this](const SetPose& given) { localizer_->setPose(given.T_map_base, kSetPoseSigma); });
  exchange_.wheels.drain([this](const WheelReading& reading) {
    localizer_->add(reading.sample);
    probe_.add(reading.sample);
  });
  exchange_.imu.drain([this](const ImuSample& sample) {
    localizer_->add(sample);
    probe_.add(sample);
  });
  exchange_.views.drain([this](const PseudoLaser& laser) {
    if (const DepthSight* sight = localizer_->add(laser)) exchange_.sights.tryPush(*sight);
  });
  bool scanned = false;
  exchange_.scans.popOne([&](const ReceivedScan& received) { scanned = addScan(received); });

  if (ticks_++ % ticks_per_pose_ != 0 && !scanned) return;
  const Timestamp now = monotonicNow();
  snapshot_.pose = localizer_->estimate(now);
  snapshot_.odometry = localizer_->odometry(now);
  exchange_.moving = isMoving(snapshot_.odometry.twist);
  snapshot_.counters = localizer_->counters();
  snapshot_.filter = localizer_->filterCounters();
  snapshot_.findings = withDistances(probe_.findings(), localizer_->wheelScale());
  exchange_.pose_for_bus.store(snapshot_);
  exchange_.pose_for_supervisor.store(snapshot_);
  exchange_.pose_for_graph.store(snapshot_);
  exchange_.bus_wakeup.notify();
  if (scanned) probe_.work();  // when the pose is out
}

bool EstimatorThread::addScan(const ReceivedScan& received) {
  const Timestamp begin = monotonicNow();
  const ScanOutcome outcome = slam::addScan(*localizer_, probe_, received.scan, exchange_.keyframes.hasRoom());
  exchange_.lidar_stuck = outcome.stuck;
  if (outcome.stuck) return false;
  exchange_.scan_work.add(monotonicNow() - begin);
  if (outcome.match.iterations > 0) exchange_.match.add(outcome.match_time);
  if (outcome.keyframe != nullptr) exchange_.keyframes.tryPush(*outcome.keyframe);
  ++snapshot_.scans;
  snapshot_.scan_received = received.received;
  return true;
}

}  // namespace slam
