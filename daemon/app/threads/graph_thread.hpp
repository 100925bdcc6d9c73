// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <memory>

#include "app/channels.hpp"
#include "app/map/graph_work.hpp"
#include "app/map/map_jobs.hpp"
#include "app/map/store_policy.hpp"
#include "config/config.hpp"
#include "frontend/front_end.hpp"
#include "runtime/clock.hpp"
#include "runtime/worker.hpp"

namespace slam {

/// Thread *graph*: works on the map, and has it loaded and stored. It may take its time: nobody waits for it.
class GraphThread {
 public:
  GraphThread(const Config& config, const GraphEnds& ends, const WallClock& clock);
  ~GraphThread() { worker_.stop(); }
  Worker& worker() { return worker_; }
  MapJobs& jobs() { return jobs_; }
  const MapJobs& jobs() const { return jobs_; }

  /// The front end for the map to begin with.
  std::unique_ptr<FrontEnd> firstFrontEnd() const { return work_.newFrontEnd(); }

  /// For after the thread has stopped: takes what is left in the queue. Call it before the mapper's finish().
  void finish();

 private:
  void tick();

  const GraphEnds ends_;
  StorePolicy policy_;
  GraphWork work_;
  MapJobs jobs_;
  Worker worker_;
};

}  // namespace slam
