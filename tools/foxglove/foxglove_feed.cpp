// SPDX-License-Identifier: BSD-3-Clause
#include "tools/foxglove/foxglove_feed.hpp"

#include <cmath>
#include <cstring>
#include <nlohmann/json.hpp>

#include "bus/messages.hpp"
#include "tools/foxglove/foxglove_json.hpp"

namespace slam {
namespace {

constexpr std::int64_t kMountPeriod = 1'000'000, kLogPeriod = 30'000'000;  // [us]
constexpr std::int8_t kHit = 2;                                            // of depth_t::kinds

void put(std::string& points, float x, float y, float intensity) {
  for (const float value : {x, y, 0.0F, intensity}) {
    char bytes[sizeof value];
    std::memcpy(bytes, &value, sizeof value);  // both ends are little-endian
    points.append(bytes, sizeof value);
  }
}

FoxgloveChannel channelOf(const char* topic, const char* name, const nlohmann::json& example) {
  return {topic, name, foxglove::schemaOf(name, example)};
}

}  // namespace

const std::array<FoxgloveChannel, kFoxgloveTopics>& foxgloveChannels() {
  using namespace foxglove;
  static const std::array<FoxgloveChannel, kFoxgloveTopics> kChannels = {
      channelOf("/scan", "foxglove.PointCloud", pointCloud("lidar", 0, "")),
      channelOf("/depth", "foxglove.PointCloud", pointCloud("camera", 0, "")),
      channelOf("/pose", "foxglove.PoseInFrame", poseInFrame("map", 0, {})),
      channelOf("/estimate", "slam.estimate", estimate(pose_estimate_t{})),
      channelOf("/odometry", "foxglove.PoseInFrame", poseInFrame("odom", 0, {})),
      channelOf("/tf", "foxglove.FrameTransform", frameTransform(0, "map", "base", {})),
      channelOf("/map", "foxglove.Grid", grid({})),
      channelOf("/wheels", "slam.wheels", wheels(wheels_t{})),
      channelOf("/imu", "slam.imu", imu(imu_t{})),
      channelOf("/health", "slam.health", health(health_t{})),
      channelOf("/log", "foxglove.Log", log(0, problem_t{})),
  };
  return kChannels;
}

FoxgloveFeed::FoxgloveFeed(Sink sink, Wanted wanted) : sink_(std::move(sink)), wanted_(std::move(wanted)) {}

void FoxgloveFeed::mount(const Config& config) {
  T_base_lidar_ = config.front_end.lidar.T_base_lidar;
  upside_down_ = config.front_end.lidar.upside_down;
  T_base_camera_ = config.depth_device.projection.extrinsics.levelled();
}

bool FoxgloveFeed::take(const scan_t& message) {
  const auto scan = fromMessage(message);
  if (!scan) return false;
  if (std::abs(message.utime - mounted_) >= kMountPeriod) {
    mounted_ = message.utime;
    transform(message.utime, "base", "lidar", T_base_lidar_);
    transform(message.utime, "base", "camera", T_base_camera_);
  }
  if (!isWanted(FoxgloveTopic::kScan)) return true;
  std::string points;
  for (const Beam& beam : scan->beams()) {
    if (!scan->isReturn(beam)) continue;
    const float left = upside_down_ ? -beam.range : beam.range;
    put(points, beam.range * std::cos(beam.bearing), left * std::sin(beam.bearing), beam.intensity);
  }
  sink_(FoxgloveTopic::kScan, message.utime, foxglove::pointCloud("lidar", message.utime, points));
  return true;
}

bool FoxgloveFeed::take(const depth_t& message) {
  if (!fromMessage(message)) return false;
  if (!isWanted(FoxgloveTopic::kDepth)) return true;
  std::string points;
  for (int i = 0; i < message.nbeams; ++i) {
    const auto at = static_cast<std::size_t>(i);
    if (message.kinds[at] != kHit) continue;
    const float bearing = message.bearing_min + message.bearing_step * static_cast<float>(i);
    put(points, message.ranges[at] * std::cos(bearing), message.ranges[at] * std::sin(bearing), 0.0F);
  }
  sink_(FoxgloveTopic::kDepth, message.utime, foxglove::pointCloud("camera", message.utime, points));
  return true;
}

void FoxgloveFeed::take(const wheels_t& message) {
  if (isWanted(FoxgloveTopic::kWheels)) sink_(FoxgloveTopic::kWheels, message.utime, foxglove::wheels(message));
}

void FoxgloveFeed::take(const imu_t& message) {
  if (isWanted(FoxgloveTopic::kImu)) sink_(FoxgloveTopic::kImu, message.utime, foxglove::imu(message));
}

void FoxgloveFeed::take(const pose_estimate_t& message) {
  const Pose2 pose{message.x, message.y, message.theta};
  if (!placed_from_outside_) place(message.utime, pose);
  if (isWanted(FoxgloveTopic::kPose))
    sink_(FoxgloveTopic::kPose, message.utime, foxglove::poseInFrame("map", message.utime, pose));
  if (isWanted(FoxgloveTopic::kEstimate)) sink_(FoxgloveTopic::kEstimate, message.utime, foxglove::estimate(message));
}

void FoxgloveFeed::take(const odometry_t& message) {
  if (!isWanted(FoxgloveTopic::kOdometry)) return;
  const Pose2 pose{message.x, message.y, message.theta};
  sink_(FoxgloveTopic::kOdometry, message.utime, foxglove::poseInFrame("odom", message.utime, pose));
}

void FoxgloveFeed::take(const health_t& message) {
  if (isWanted(FoxgloveTopic::kHealth)) sink_(FoxgloveTopic::kHealth, message.utime, foxglove::health(message));
}

void FoxgloveFeed::take(const problems_t& message) {
  if (!isWanted(FoxgloveTopic::kLog)) return logged_.clear();
  decltype(logged_) standing;
  for (const problem_t& problem : message.problems) {
    std::pair key{problem.device, problem.id};
    const auto before = logged_.find(key);
    const bool is_due = before == logged_.end() || std::abs(message.utime - before->second) >= kLogPeriod;
    if (is_due) sink_(FoxgloveTopic::kLog, message.utime, foxglove::log(message.utime, problem));
    standing.emplace(std::move(key), is_due ? message.utime : before->second);
  }
  logged_ = std::move(standing);
}

void FoxgloveFeed::take(const MapPicture::Picture& map) {
  if (isWanted(FoxgloveTopic::kMap)) sink_(FoxgloveTopic::kMap, map.utime, foxglove::grid(map));
}

void FoxgloveFeed::place(std::int64_t utime, const Pose2& T_map_base) { transform(utime, "map", "base", T_map_base); }

void FoxgloveFeed::transform(std::int64_t utime, const char* parent, const char* child, const Pose2& pose) {
  if (isWanted(FoxgloveTopic::kTransform))
    sink_(FoxgloveTopic::kTransform, utime, foxglove::frameTransform(utime, parent, child, pose));
}

}  // namespace slam
