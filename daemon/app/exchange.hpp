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
#include "core/samples.hpp"
#include "core/scan.hpp"
#include "runtime/latency_histogram.hpp"
#include "runtime/latest_value.hpp"
#include "runtime/spsc_queue.hpp"
#include "runtime/wakeup.hpp"
#include "slam/localizer.hpp"
#include "slam/mapper.hpp"
#include "slam/sensor_check.hpp"

namespace slam {

/// A wheel sample with the angles it was made from, for the log.
struct WheelReading {
  WheelSample sample;
  std::array<double, 2> angles{};  ///< [rad] left, right
};

struct ReceivedScan {
  LaserScan scan;
  Timestamp received;  ///< when its last beam had been decoded
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

/// What the graph thread tells the mapper: scans to draw, and new poses when a loop was closed.
struct MapChange {
  std::int32_t map_id = 0;
  Timestamp stamp;
  std::vector<MapScan> scans;
  std::vector<Pose2> poses;  ///< of keyframes 0, 1, ...; empty: as before
};

/// A command that the estimator carries out.
struct EstimatorCommand {
  enum Kind : std::uint8_t { kSetPose, kReset } kind = kSetPose;
  Pose2 T_map_base;
};

enum class SaveOutcome : std::uint8_t { kNone, kSaved, kFailed };

/// All that crosses threads. Each queue has one producer and one consumer, named in its comment.
struct Exchange {
  // base (or bus, for a sensor from LCM) -> estimator
  SpscQueue<WheelReading> wheels{256};
  SpscQueue<ImuSample> imu{256};
  SpscQueue<ReceivedScan> scans{8};  // lidar (or bus) -> estimator
  // base, lidar -> bus: the raw samples of our own devices
  SpscQueue<WheelReading> wheels_out{256};
  SpscQueue<ImuSample> imu_out{256};
  SpscQueue<ReceivedScan> scans_out{8};

  SpscQueue<Keyframe> keyframes{64};                             // estimator -> graph
  SpscQueue<MapCorrection*> corrections{2};                      // graph -> estimator, who gives it back by
  SpscQueue<MapCorrection*> used_corrections{2};                 // estimator -> graph: one at most is on its way
  SpscQueue<std::shared_ptr<const MapChange>> map_changes{256};  // graph -> mapper
  SpscQueue<EstimatorCommand> commands{8};                       // bus -> estimator
  SpscQueue<map_meta_t> map_meta{4};                             // mapper -> bus
  SpscQueue<map_tile_t> map_tiles{256};                          // mapper -> bus
  SpscQueue<health_t> health{4};                                 // supervisor -> bus

  LatestValue<PoseSnapshot> pose_for_bus;         // estimator -> bus
  LatestValue<PoseSnapshot> pose_for_supervisor;  // estimator -> supervisor
  Wakeup bus_wakeup;                              // estimator, mapper, supervisor -> bus

  std::atomic<bool> save_map{false};                       // bus -> mapper
  std::atomic<SaveOutcome> map_saved{SaveOutcome::kNone};  // mapper -> bus: of the last save_map
  std::atomic<bool> refresh_map{false};                    // bus -> mapper: all tiles again
  LatencyHistogram match, scan_work, scan_to_pose, map_update, optimise;
  std::atomic<std::int64_t> published{0}, publish_failures{0}, bad_messages{0}, map_keyframes{0};
  std::atomic<std::int64_t> loop_closures{0}, revoked_closures{0};
};

}  // namespace slam
