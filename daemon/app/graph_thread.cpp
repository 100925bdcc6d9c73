// SPDX-License-Identifier: BSD-3-Clause
#include "app/graph_thread.hpp"

#include "app/log.hpp"
#include "runtime/clock.hpp"

namespace slam {
namespace {

constexpr double kRate = 20.0;  // [Hz] keyframes come at a few per second

}  // namespace

GraphThread::GraphThread(const Config& config, Exchange& exchange)
    : exchange_(exchange),
      config_(backEndConfig(config)),
      back_end_(std::make_unique<BackEnd>(config_)),
      worker_({.name = "graph", .rate = kRate}, [this] { tick(); }) {}

GraphThread::~GraphThread() {
  worker_.stop();
  for (auto* queue : {&exchange_.corrections, &exchange_.used_corrections}) {
    queue->drain([](MapCorrection* correction) { delete correction; });
  }
}

void GraphThread::tick() {
  exchange_.used_corrections.drain([this](MapCorrection* used) {
    back_end_->recycle(std::unique_ptr<MapCorrection>(used));
    correction_away_ = false;
  });
  exchange_.keyframes.drain([this](const Keyframe& keyframe) { add(keyframe); });
  sendChanges();
}

void GraphThread::add(const Keyframe& keyframe) {
  if (keyframe.map_id != map_id_) {  // the estimator began anew
    back_end_ = std::make_unique<BackEnd>(config_);
    map_id_ = keyframe.map_id;
    generation_ = 0;
  }
  const Timestamp begin = monotonicNow();
  back_end_->add(keyframe, !correction_away_);
  auto change = std::make_shared<MapChange>();
  change->map_id = map_id_;
  change->stamp = keyframe.stamp;
  change->scans = back_end_->mapScans(keyframe);
  if (generation_ != back_end_->generation()) {
    const BackEndCounters& counters = back_end_->counters();
    exchange_.optimise.add(monotonicNow() - begin);
    exchange_.loop_closures = counters.loop_closures;
    exchange_.revoked_closures = counters.revoked;
    generation_ = back_end_->generation();
    const auto poses = back_end_->keyframes().graph().poses();
    change->poses.assign(poses.begin(), poses.end());
    logInfo("loop closed: " + std::to_string(counters.loop_closures) + " closures join " +
            std::to_string(counters.keyframes) + " keyframes");
  }
  changes_.push_back(std::move(change));
  if (auto correction = back_end_->takeCorrection()) {
    correction->map_id = map_id_;
    correction_away_ = exchange_.corrections.tryPush(correction.get());
    correction_away_ ? static_cast<void>(correction.release()) : back_end_->recycle(std::move(correction));
  }
}

void GraphThread::sendChanges() {
  while (!changes_.empty() && exchange_.map_changes.hasRoom()) {
    exchange_.map_changes.tryPush(changes_.front());
    changes_.pop_front();
  }
}

void GraphThread::finish() {
  exchange_.keyframes.drain([this](const Keyframe& keyframe) { add(keyframe); });
  sendChanges();
}

}  // namespace slam
