// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <deque>
#include <memory>

#include "app/config.hpp"
#include "app/exchange.hpp"
#include "runtime/worker.hpp"
#include "slam/back_end.hpp"

namespace slam {

/// Thread *graph*: puts keyframes into the pose graph, closes loops, and hands corrections to the estimator and what
/// is to be drawn to the mapper. It may take its time: nobody waits for it.
class GraphThread {
 public:
  GraphThread(const Config& config, Exchange& exchange);
  ~GraphThread();
  Worker& worker() { return worker_; }

  /// For after the thread has stopped: takes what is left in the queue. Call it before the mapper's finish().
  void finish();

 private:
  void tick();
  void add(const Keyframe& keyframe);
  void sendChanges();

  Exchange& exchange_;
  BackEndConfig config_;
  std::unique_ptr<BackEnd> back_end_;
  std::int32_t map_id_ = 0;
  int generation_ = 0;
  bool correction_away_ = false;
  std::deque<std::shared_ptr<const MapChange>> changes_;  // not yet in the mapper's queue
  Worker worker_;
};

}  // namespace slam
