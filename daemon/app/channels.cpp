// SPDX-License-Identifier: BSD-3-Clause
#include "app/channels.hpp"

#include "frontend/front_end.hpp"

namespace slam {

Channels::~Channels() {
  for (auto* queue : {&front_end.corrections, &front_end.used_corrections}) {
    queue->drain([](MapCorrection* correction) { delete correction; });
  }
  for (auto* queue : {&front_end.front_ends, &front_end.used_front_ends}) {
    queue->drain([](FrontEnd* unused) { delete unused; });
  }
}

EstimatorEnds Channels::estimator() {
  return {samples.ends<Consumer>(),
          commands.set_poses,
          front_end.ends<Producer, Consumer>(),
          newest_pose,
          pose_for_supervisor,
          pose_for_graph,
          moving,
          lidar_stuck,
          times.match,
          times.scan_work,
          estimator_wakeup,
          pose_wakeup};
}

GraphEnds Channels::graph() {
  return {front_end.ends<Consumer, Producer>(),
          map.ends<Producer, Consumer>(),
          commands.map,
          answers,
          edits,
          pose_for_graph,
          graph_counters,
          times.loop_closure};
}

MapperEnds Channels::mapper() {
  return {map.ends<Consumer, Producer>(), tiles.ends<Producer>(), requests, map_keyframes, times.map, bus_wakeup};
}

BusEnds Channels::bus() {
  return {samples.ends<Producer>(),
          raw.ends<Consumer>(),
          commands.ends<Producer>(),
          answers,
          edits,
          tiles.ends<Consumer>(),
          requests,
          health,
          sent_poses,
          bus_counters,
          bus_wakeup,
          estimator_wakeup};
}

}  // namespace slam
