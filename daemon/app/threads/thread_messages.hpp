// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <slam/health_t.hpp>
#include <slam/problems_t.hpp>
#include <string>
#include <vector>

#include "bus/udpm/lcm_sender.hpp"
#include "core/estimates.hpp"
#include "core/samples.hpp"
#include "core/scan.hpp"
#include "diagnostics/sensor_check.hpp"
#include "estimation/ekf.hpp"
#include "frontend/front_end_state.hpp"
#include "frontend/interpreter/echo_watch.hpp"
#include "mapping/mapper.hpp"
#include "problems/answer.hpp"
#include "slam/map_state.hpp"

/// What the threads hand to each other, beside the samples and maps themselves.
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
  FrontEndCounters counters;
  EkfCounters filter;
  SensorFindings findings;
  TrackingReport tracking;
  EchoWatch::Finding echo_finding = EchoWatch::Finding::kNone;
  BodyShape body;       ///< what moves with the robot
  double echoes = 0.0;  ///< [1] share of the beams of the newest scan that can be used
};

/// How slamd is, for the bus.
struct HealthReport {
  problems_t problems;
  health_t health;
};

/// A pose that the pose thread publishes, for the records and for who judges the link.
struct SentPose {
  PoseEstimate pose;
  OdometryEstimate odometry;
  std::int32_t map_id = 0;
  std::int64_t utime = 0;  ///< [us] of its messages
  Timestamp sent;
  LcmSender::Outcome before;  ///< how the last message of the pose before was sent
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
  std::optional<EditedDrawing> edits;        ///< what they ask; nothing: as before
  std::vector<Outline> anew;                 ///< [m] in map: with `edits`, whatever was drawn within them
  std::shared_ptr<const MapState> begin_in;  ///< set: a stored map to go on in
  bool send_grid = false;
};

/// A command about the map, for the graph thread.
struct MapCommand {
  // clang-format off
  enum Kind : std::uint8_t { kSave, kLoad, kReset, kLocalise, kSlam, kEdit, kStraighten, kRename, kDelete, kRestore };
  // clang-format on
  Kind kind = kSave;
  std::int32_t id = 0;  ///< of the message
  std::string name;     ///< of a map; empty: the present one; of kStraighten: of the place at the origin;
                        ///< of kRename: the old one, a blank, and the new one
  std::shared_ptr<const EditCommand> edit = nullptr;  ///< of kEdit
  std::shared_ptr<const FloorFound> floor = nullptr;  ///< of kLoad: slamd has found the robot there, and nobody asked
  Problem done = {};                                  ///< what an edit has done, once it has
};

/// The answer to one.
struct MapAnswer {
  std::int32_t id = 0;
  bool accepted = false;
  Answer answer;
};

/// A pose that a person gives.
struct SetPose {
  Pose2 T_map_base;
};

enum class SaveOutcome : std::uint8_t { kNone, kSaved, kFailed };

}  // namespace slam
