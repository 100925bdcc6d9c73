// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <array>
#include <atomic>
#include <memory>
#include <optional>
#include <slam/health_t.hpp>
#include <slam/map_meta_t.hpp>
#include <slam/map_tile_t.hpp>
#include <vector>

#include "core/estimates.hpp"
#include "core/keyframe.hpp"
#include "core/pseudo_laser.hpp"
#include "core/samples.hpp"
#include "core/scan.hpp"
#include "runtime/latency_histogram.hpp"
#include "runtime/latest_value.hpp"
#include "runtime/spsc_queue.hpp"
#include "runtime/wakeup.hpp"
#include "slam/localizer.hpp"
#include "slam/map_state.hpp"
#include "slam/mapper.hpp"
#include "slam/sensor_check.hpp"

namespace slam {

/// A wheel sample with the angles it was made from, for the log.
struct WheelReading {
  WheelSample sample;
  std::array<double, 4> angles{};  ///< [rad] as WheelAngles has them
  int count = 0;                   ///< of the angles that are known
};

struct ReceivedScan {
  LaserScan scan;
  Timestamp received;  ///< when its last beam had been decoded
};

/// What the base shall do, and since when: it must not be obeyed later because it waited in a queue.
struct DriveCommand {
  Twist2 twist;
  Timestamp given;  ///< never later than now
};

/// What the estimator tells everybody at each tick.
struct PoseSnapshot {
  PoseEstimate pose;
  OdometryEstimate odometry;
  std::int32_t map_id = 0;
  std::int64_t scans = 0;     ///< processed so far
  Timestamp scan_received{};  ///< of the newest one
  LocalizerCounters counters;
  EkfCounters filter;
  SensorFindings findings;
};

/// The mapper's share of a map: what is drawn, and the depth views it was drawn from.
struct DrawnMap {
  OccupancyGrid grid;
  std::vector<MapView> views;
};

/// What the graph thread tells the mapper: scans and depth views to draw, new poses when a loop was closed, another
/// map, or that it wants a copy of the grid.
struct MapChange {
  std::int32_t map_id = 0;
  Timestamp stamp;
  int first_in_map = 0;  ///< keyframes with lower ids are no part of the map any more
  std::vector<MapScan> scans;
  std::vector<MapView> views;
  std::vector<Pose2> poses;                  ///< of keyframes 0, 1, ...; empty: as before
  std::shared_ptr<const MapState> begin_in;  ///< set: a stored map to go on in
  bool send_grid = false;
};

/// A command about the map, for the graph thread.
struct MapCommand {
  enum Kind : std::uint8_t { kSave, kLoad, kReset, kLocalise, kSlam } kind = kSave;
  std::int32_t id = 0;  ///< of the message
  std::string name;     ///< of a map; empty: the present one
};

/// The answer to one.
struct MapAnswer {
  std::int32_t id = 0;
  bool accepted = false;
  std::string message;
};

/// A pose that a person gives.
struct SetPose {
  Pose2 T_map_base;
};

enum class SaveOutcome : std::uint8_t { kNone, kSaved, kFailed };

/// All that crosses threads. Each queue has one producer and one consumer, named in its comment.
struct Exchange {
  // base (or bus, for a sensor from LCM) -> estimator
  SpscQueue<WheelReading> wheels{256};
  SpscQueue<ImuSample> imu{256};
  SpscQueue<ReceivedScan> scans{8};  // lidar (or bus) -> estimator
  SpscQueue<PseudoLaser> views{8};   // depth (or bus) -> estimator
  // base, lidar, depth -> bus: the raw samples of our own devices
  SpscQueue<WheelReading> wheels_out{256};
  SpscQueue<ImuSample> imu_out{256};
  SpscQueue<ReceivedScan> scans_out{8};
  SpscQueue<PseudoLaser> views_out{8};

  // estimator -> graph; one more may come while a correction is handed over
  SpscQueue<Keyframe> keyframes{Localizer::kMostAhead - 1};
  SpscQueue<DepthSight> sights{64};                              // estimator -> graph
  SpscQueue<MapCorrection*> corrections{2};                      // graph -> estimator, who gives it back by
  SpscQueue<MapCorrection*> used_corrections{2};                 // estimator -> graph: one at most is on its way
  SpscQueue<std::shared_ptr<const MapChange>> map_changes{256};  // graph -> mapper
  SpscQueue<DriveCommand> drives{8};                             // bus -> base
  SpscQueue<SetPose> set_poses{8};                               // bus -> estimator
  SpscQueue<MapCommand> map_commands{8};                         // bus -> graph
  SpscQueue<MapAnswer> map_answers{16};                          // graph -> bus
  SpscQueue<std::shared_ptr<DrawnMap>> grids{2};                 // mapper -> graph: copies, on request
  SpscQueue<Localizer*> localizers{2};                           // graph -> estimator: begins in another map ...
  SpscQueue<Localizer*> used_localizers{2};                      // estimator -> graph: ... and gives the old one back
  SpscQueue<map_meta_t> map_meta{4};                             // mapper -> bus
  SpscQueue<map_tile_t> map_tiles{256};                          // mapper -> bus
  SpscQueue<map_tile_t> lidar_tiles{32}, depth_tiles{32};        // mapper -> bus: its layers
  SpscQueue<health_t> health{4};                                 // supervisor -> bus

  LatestValue<PoseSnapshot> pose_for_bus;         // estimator -> bus
  LatestValue<PoseSnapshot> pose_for_supervisor;  // estimator -> supervisor
  LatestValue<PoseSnapshot> pose_for_graph;       // estimator -> graph
  Wakeup bus_wakeup;                              // estimator, mapper, supervisor -> bus

  std::atomic<bool> save_map{false};                       // bus -> mapper
  std::atomic<SaveOutcome> map_saved{SaveOutcome::kNone};  // mapper -> bus: of the last save_map
  std::atomic<bool> moving{false};                         // estimator -> depth: wheels and gyro say so
  std::atomic<bool> lidar_stuck{false};  // estimator -> supervisor: it repeats a turn although the robot moves
  std::atomic<bool> refresh_map{false};  // bus -> mapper: all tiles again
  LatencyHistogram match, scan_work, scan_to_pose, map_update, optimise, depth_work;
  std::atomic<std::int64_t> published{0}, publish_failures{0}, bad_messages{0}, map_keyframes{0};
  std::atomic<std::uint64_t> lcm_fragments{0}, lcm_other_packets{0}, lcm_dropped{0};  // bus -> supervisor
  std::atomic<std::uint64_t> socket_clients{0}, socket_bad{0}, socket_dropped{0}, socket_refused{0};  // the same
  std::atomic<std::int64_t> loop_closures{0}, revoked_closures{0}, relocalised{0}, maps_begun_anew{0};
};

}  // namespace slam
