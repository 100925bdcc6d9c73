// SPDX-License-Identifier: BSD-3-Clause
#include "app/threads/estimator_thread.hpp"

#include <cmath>
#include <utility>

#include "app/device_configs.hpp"
#include "runtime/clock.hpp"

namespace slam {
namespace {

const Eigen::Vector3d kSetPoseSigma(0.2, 0.2, 0.1);  // [m, m, rad] of a pose given by a person

}  // namespace

EstimatorThread::EstimatorThread(const Config& config, const EstimatorEnds& ends, std::unique_ptr<FrontEnd> front_end)
    : ends_(ends),
      front_end_(std::move(front_end)),
      probe_(config.front_end),
      ticks_per_pose_(ticksPerPose(config)),
      worker_(
          estimatorWorker(config), [this] { tick(); }, ends.wakeup,
          [this] {
            takeIn();
            if (scanned_) handOverPose();
          }) {
  snapshot_.map_id = front_end_->mapId();
}

void EstimatorThread::tick() {
  takeIn();
  if (ticks_++ % ticks_per_pose_ == 0 || scanned_) handOverPose();
}

void EstimatorThread::takeIn() {
  ends_.graph.front_ends.popOne([this](FrontEnd* fresh) {
    ends_.graph.used_front_ends.tryPush(front_end_.release());
    front_end_.reset(fresh);
    snapshot_.map_id = fresh->mapId();
  });
  ends_.graph.corrections.popOne([this](MapCorrection* correction) {
    if (correction->map_id == snapshot_.map_id) front_end_->apply(*correction);
    ends_.graph.used_corrections.tryPush(correction);
  });
  ends_.set_poses.drain([this](const SetPose& given) { front_end_->setPose(given.T_map_base, kSetPoseSigma); });
  ends_.samples.wheels.drain([this](const WheelReading& reading) {
    front_end_->add(reading.sample);
    probe_.add(reading.sample);
  });
  ends_.samples.imu.drain([this](const ImuSample& sample) {
    front_end_->add(sample);
    probe_.add(sample);
  });
  ends_.samples.views.drain([this](const PseudoLaser& laser) {
    if (const DepthObservation* sight = front_end_->add(laser)) ends_.graph.sights.tryPush(*sight);
  });
  ends_.samples.scans.popOne([this](const ReceivedScan& received) { scanned_ = addScan(received); });
}

void EstimatorThread::handOverPose() {
  const Timestamp now = monotonicNow();
  snapshot_.pose = front_end_->estimate(now);
  snapshot_.odometry = front_end_->odometry(now);
  const Twist2& twist = snapshot_.odometry.twist;
  ends_.moving = !front_end_->config().ekf.standstill.isQuiet(std::hypot(twist.vx, twist.vy), twist.omega);
  snapshot_.counters = front_end_->counters();
  snapshot_.filter = front_end_->filterCounters();
  snapshot_.tracking = front_end_->trackingReport(now);
  snapshot_.echo_finding = echoes_.finding();
  snapshot_.echoes = echoes_.share();
  snapshot_.findings = findingsOf(probe_, *front_end_);
  snapshot_.body = front_end_->interpreter().body();
  ends_.pose.store(snapshot_);
  ends_.pose_wakeup.notify();
  ends_.pose_for_supervisor.store(snapshot_);
  ends_.pose_for_graph.store(snapshot_);
  if (std::exchange(scanned_, false)) probe_.work();  // when the pose is out
}

bool EstimatorThread::addScan(const ReceivedScan& received) {
  const Timestamp begin = monotonicNow();
  const LidarModel& lidar = front_end_->config().lidar;
  echoes_.add(received.scan, {static_cast<float>(lidar.range_min), static_cast<float>(lidar.range_max)},
              received.received);
  const ScanOutcome outcome = front_end_->add(received.scan, ends_.graph.keyframes.hasRoom());
  probe_.add(outcome, front_end_->lidarDelay().used());
  ends_.lidar_stuck = outcome.stuck;
  if (outcome.stuck) return false;
  ends_.scan_work.add(monotonicNow() - begin);
  if (outcome.match.iterations > 0) ends_.match.add(outcome.match_time);
  if (outcome.keyframe != nullptr) ends_.graph.keyframes.tryPush(*outcome.keyframe);
  ++snapshot_.scans;
  snapshot_.scan_received = received.received;
  return true;
}

}  // namespace slam
