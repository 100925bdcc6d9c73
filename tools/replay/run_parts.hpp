// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <cstdint>
#include <deque>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "bus/event_log.hpp"
#include "bus/received.hpp"
#include "frontend/interpreter/echo_watch.hpp"
#include "matching/deskew.hpp"
#include "slam/pipeline.hpp"
#include "tools/common/trajectory.hpp"
#include "tools/replay/estimates.hpp"
#include "tools/replay/replay.hpp"
#include "tools/replay/viewer_frames.hpp"

namespace slam {

/// A sensor's messages in a log: what is refused is counted.
template <typename Message>
class SensorInput {
 public:
  SensorInput(std::string_view channel, bool used) : channel_(channel), used_(used), refused_(channel) {}

  /// @param use is called with message and sample if the event is one of this sensor
  template <typename Use>
  void take(const LogEvent& event, Use&& use) {
    if (!used_ || event.channel != channel_) return;
    const Received<Message> received(event.data);
    refused_.count(received.refusal);
    if (received) {
      use(*received.message, *received.sample);
    } else {
      ++rejected_;
    }
  }
  std::uint64_t rejected() const { return rejected_; }
  std::string refusals() const { return refused_.words(); }  ///< how many and why; empty: none

 private:
  std::string_view channel_;
  bool used_;
  RefusedMessages refused_;
  std::uint64_t rejected_ = 0;
};

/// The poses of a run, as they are known at once and at the end.
class RunPoses {
 public:
  /// @param localise_only in a given map, whose keyframes stay @throws std::runtime_error when a file cannot be written
  RunPoses(const ReplayOptions& options, bool localise_only);

  void addWheels(std::int64_t utime, const Pose2& T_wheels_base);
  /// Before a correction moves the keyframes.
  void add(std::int64_t utime, const ScanEstimate& estimate, const FrontEnd& front_end);
  /// A session was found in the given map: where the robot was since it got lost is known now.
  void place(const Pose2& T_map_session, std::int32_t session);
  /// @param keyframes at the end @throws std::runtime_error when a file was not written whole
  void finish(const KeyframeGraph& keyframes);
  std::int64_t lastUtime() const { return rows_.empty() ? 0 : rows_.back().utime; }  ///< [us] 0: there is none

 private:
  struct Row {
    std::int64_t utime;
    std::int32_t session;
    std::int32_t keyframe;  // -1: the pose is that in map
    Pose2 T_keyframe_base;
  };
  std::optional<TrajectoryWriter> final_, causal_, odometry_, wheels_;
  bool localise_only_;
  std::deque<Row> rows_;
};

/// Pictures of a run, with its newest scan.
class RunFrames {
 public:
  RunFrames(const std::filesystem::path& folder, double period) : viewer_(folder, period) {}

  /// Draws a frame if one is due. @param log_s [s] since the log's begin
  void add(const LaserScan& scan, Timestamp stamp, double log_s, Pipeline& pipeline);
  void finish(double log_s, Pipeline& pipeline);

 private:
  void draw(double log_s, Pipeline& pipeline);

  ViewerFrames viewer_;
  ScanPoints points_;
  std::vector<Eigen::Vector2d> seen_;  // points of the newest scan in base
  Timestamp stamp_;                    // of the same
};

/// A lidar that was stuck or blind.
class LidarWatch {
 public:
  void add(const LaserScan& scan, const LidarModel& lidar);
  void noteStuck(bool stuck) { stuck_ += stuck; }
  void warn(ReplayStats& stats) const;

 private:
  int stuck_ = 0, blind_ = 0;  // scans
  EchoWatch echoes_;
  EchoWatch::Finding finding_ = EchoWatch::Finding::kNone;
};

}  // namespace slam
