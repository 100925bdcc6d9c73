// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <array>
#include <cstdint>
#include <functional>
#include <map>
#include <nlohmann/json_fwd.hpp>
#include <slam/depth_t.hpp>
#include <slam/health_t.hpp>
#include <slam/imu_t.hpp>
#include <slam/odometry_t.hpp>
#include <slam/pose_estimate_t.hpp>
#include <slam/problems_t.hpp>
#include <slam/scan_t.hpp>
#include <slam/wheels_t.hpp>
#include <string>
#include <utility>

#include "config/config.hpp"
#include "tools/foxglove/map_picture.hpp"

namespace slam {

enum class FoxgloveTopic : std::uint8_t {
  kScan,
  kDepth,
  kPose,
  kEstimate,
  kOdometry,
  kTransform,
  kMap,
  kWheels,
  kImu,
  kHealth,
  kLog
};
inline constexpr std::size_t kFoxgloveTopics = 11;

/// A channel as viewers see it. Messages are JSON, described by JSON Schema.
struct FoxgloveChannel {
  std::string topic;        ///< such as "/scan"
  std::string schema_name;  ///< such as "foxglove.PointCloud"
  std::string schema;
};
/// By FoxgloveTopic.
const std::array<FoxgloveChannel, kFoxgloveTopics>& foxgloveChannels();

/// slamd's messages as those that Foxglove shows: of a recording, and live.
class FoxgloveFeed {
 public:
  /// @param utime [us since the epoch] of the message
  using Sink = std::function<void(FoxgloveTopic topic, std::int64_t utime, const nlohmann::json& message)>;
  using Wanted = std::function<bool(FoxgloveTopic topic)>;

  /// @param wanted whether anybody wants a topic, so that nothing is written in vain; nothing: all are wanted
  explicit FoxgloveFeed(Sink sink, Wanted wanted = nullptr);

  /// Where lidar and camera sit; at the origin of base until this is called.
  void mount(const Config& config);
  /// Poses come by place(), and those of the estimate are not frames.
  void takePlacesFromOutside() { placed_from_outside_ = true; }

  /// @return false: it is no measurement
  bool take(const scan_t& message);
  bool take(const depth_t& message);
  void take(const wheels_t& message);
  void take(const imu_t& message);
  void take(const pose_estimate_t& message);
  void take(const odometry_t& message);
  void take(const health_t& message);
  /// A problem is a line of the log when it begins, and again each 30 s.
  void take(const problems_t& message);
  void take(const MapPicture::Picture& map);
  /// Of base in map. @param utime [us since the epoch]
  void place(std::int64_t utime, const Pose2& T_map_base);

 private:
  bool isWanted(FoxgloveTopic topic) const { return !wanted_ || wanted_(topic); }
  void transform(std::int64_t utime, const char* parent, const char* child, const Pose2& pose);

  Sink sink_;
  Wanted wanted_;
  Pose2 T_base_lidar_, T_base_camera_;
  bool upside_down_ = false, placed_from_outside_ = false;
  std::int64_t mounted_ = 0;                                            // [us] when the mounts were sent last
  std::map<std::pair<std::string, std::string>, std::int64_t> logged_;  // [us] by device and id
};

}  // namespace slam
