// SPDX-License-Identifier: BSD-3-Clause
// What Foxglove shows by itself has its types (docs.foxglove.dev/docs/visualization/message-schemas), the rest slamd's.
#include <algorithm>
#include <cmath>
#include <cstring>
#include <map>
#include <nlohmann/json.hpp>

#include "config/loader.hpp"
#include "tools/common/trajectory.hpp"
#include "tools/convert/bags/log_export.hpp"
#include "tools/convert/bags/mcap_writer.hpp"
#include "tools/convert/formats.hpp"

namespace slam {
namespace {

using nlohmann::json;

constexpr std::int64_t kMountPeriod = 1'000'000;  // [us]

std::string base64(std::string_view bytes) {
  constexpr char kDigits[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string text;
  text.reserve((bytes.size() + 2) / 3 * 4);
  for (std::size_t i = 0; i < bytes.size(); i += 3) {
    std::uint32_t triple = 0;
    for (std::size_t k = 0; k < 3; ++k)
      triple = triple << 8 | (i + k < bytes.size() ? static_cast<std::uint8_t>(bytes[i + k]) : 0U);
    for (std::size_t k = 0; k < 4; ++k)
      text.push_back(i + k <= bytes.size() ? kDigits[triple >> (18 - 6 * k) & 63] : '=');
  }
  return text;
}

json timeOf(std::int64_t utime) { return {{"sec", utime / 1000000}, {"nsec", utime % 1000000 * 1000}}; }

json translation(const Pose2& pose) { return {{"x", pose.x}, {"y", pose.y}, {"z", 0.0}}; }

json rotation(const Pose2& pose) {
  return {{"x", 0.0}, {"y", 0.0}, {"z", std::sin(0.5 * pose.theta)}, {"w", std::cos(0.5 * pose.theta)}};
}

json poseOf(const Pose2& pose) { return {{"position", translation(pose)}, {"orientation", rotation(pose)}}; }

/// Schema of messages as this one. Viewers know the types of Foxglove by their names.
std::string schemaOf(const std::string& name, const json& message) {
  const auto kindOf = [](const json& value) {
    const char* kind = value.is_number_float()     ? "number"
                       : value.is_number_integer() ? "integer"
                       : value.is_boolean()        ? "boolean"
                       : value.is_string()         ? "string"
                                                   : "object";
    return json{{"type", kind}};
  };
  json properties = json::object();
  for (const auto& [field, value] : message.items()) {
    // Lists that may be empty are those of a base's angles, and of devices.
    const json item = value.is_array() && !value.empty() ? value.front()
                      : field == "devices"               ? json::object()
                                                         : json(0.0);
    properties[field] = value.is_array() ? json{{"type", "array"}, {"items", kindOf(item)}} : kindOf(value);
  }
  return json{{"title", name}, {"type", "object"}, {"properties", properties}}.dump();
}

/// foxglove.Grid with one byte a cell: 0 free to 100 occupied, 255 unknown.
json gridOf(const MapPicture::Picture& map) {
  return {{"timestamp", timeOf(map.utime)},
          {"frame_id", "map"},
          {"pose", poseOf(map.corner)},
          {"column_count", map.columns},
          {"cell_size", {{"x", map.resolution}, {"y", map.resolution}}},
          {"row_stride", map.columns},
          {"cell_stride", 1},
          {"fields", json::array({{{"name", "occupied"}, {"offset", 0}, {"type", 1}}})},
          {"data", base64(map.cells)}};
}

class McapExport : public LogExport<McapExport> {
 public:
  McapExport(const std::filesystem::path& out, const std::filesystem::path& trajectory) : writer_(out) {
    if (!trajectory.empty()) trajectory_ = readTrajectory(trajectory);
  }

  std::uint64_t written() const { return writer_.messages(); }
  void finish() {
    if (!placed_)
      recording_.notes.push_back("no pose in it: slam-replay --trajectory FILE makes one, --trajectory FILE takes it");
    writer_.close();
  }

 private:
  friend LogExport;

  void write(const config_t& message) {
    try {
      const Config config = parseConfig(message.configuration, channel::kConfig);
      const auto& camera = config.depth_device.projection.extrinsics;
      T_base_lidar_ = config.front_end.lidar.T_base_lidar;
      upside_down_ = config.front_end.lidar.upside_down;
      T_base_camera_ = camera.levelled();
      recording_.robot.lidar_x = T_base_lidar_.x;
      recording_.robot.lidar_y = T_base_lidar_.y;
      recording_.robot.lidar_yaw = T_base_lidar_.theta;
      recording_.robot.lidar_upside_down = upside_down_;
      recording_.robot.mount_source = channel::kConfig;
    } catch (const ConfigError& error) {
      recording_.notes.push_back(std::string("where lidar and camera sit is not known: ") + error.what());
    }
  }

  void write(const scan_t& message) {
    const auto scan = fromMessage(message);
    if (!scan) return rejectMeasurement(channel::kScan);
    recording_.use(recording_.sensor(channel::kScan), &Recording::scans, message.utime);
    if (!trajectory_.empty()) {
      if (const auto pose = poseAt(trajectory_, scan->stamp)) place(message.utime, "map", "base", *pose);
    }
    if (std::abs(message.utime - mounted_) >= kMountPeriod) {
      mounted_ = message.utime;
      transform(message.utime, "base", "lidar", T_base_lidar_);
      transform(message.utime, "base", "camera", T_base_camera_);
    }
    std::string points;
    int count = 0;
    for (const Beam& beam : scan->beams()) {
      if (!scan->isReturn(beam)) continue;
      const float left = upside_down_ ? -beam.range : beam.range;
      put(points, beam.range * std::cos(beam.bearing), left * std::sin(beam.bearing), beam.intensity);
      ++count;
    }
    cloud("/scan", "lidar", message.utime, points);
  }

  void write(const depth_t& message) {
    const auto laser = fromMessage(message);
    if (!laser) return rejectMeasurement(channel::kDepth);
    recording_.sensor(channel::kDepth).use(message.utime);
    std::string points;
    for (int i = 0; i < message.nbeams; ++i) {
      const auto at = static_cast<std::size_t>(i);
      if (message.kinds[at] != 2) continue;
      const float bearing = message.bearing_min + message.bearing_step * static_cast<float>(i);
      put(points, message.ranges[at] * std::cos(bearing), message.ranges[at] * std::sin(bearing), 0.0F);
    }
    cloud("/depth", "camera", message.utime, points);
  }

  void write(const wheels_t& message) {
    recording_.use(recording_.sensor(channel::kWheels), &Recording::wheels, message.utime);
    send("/wheels", "slam.wheels", message.utime,
         {{"x", message.x},
          {"y", message.y},
          {"theta", message.theta},
          {"turn_rate_known", message.turn_rate_known != 0},
          {"angles", message.angles}});
  }

  void write(const imu_t& message) {
    recording_.use(recording_.sensor(channel::kImu), &Recording::imu, message.utime);
    send("/imu", "slam.imu", message.utime, {{"gyro", message.gyro}, {"accel", message.accel}});
  }

  void write(const pose_estimate_t& message) {
    recording_.sensor(channel::kSlamPose).use(message.utime);
    const Pose2 pose{message.x, message.y, message.theta};
    if (trajectory_.empty()) place(message.utime, "map", "base", pose);
    send("/pose", "foxglove.PoseInFrame", message.utime,
         {{"timestamp", timeOf(message.utime)}, {"frame_id", "map"}, {"pose", poseOf(pose)}});
    send("/estimate", "slam.estimate", message.utime,
         {{"x", message.x},
          {"y", message.y},
          {"theta", message.theta},
          {"covariance", message.covariance},
          {"twist", message.twist},
          {"state", message.state},
          {"match_quality", message.match_quality},
          {"map_id", message.map_id}});
  }

  void write(const odometry_t& message) {
    recording_.sensor(channel::kOdometry).use(message.utime);
    send("/odometry", "foxglove.PoseInFrame", message.utime,
         {{"timestamp", timeOf(message.utime)},
          {"frame_id", "odom"},
          {"pose", poseOf({message.x, message.y, message.theta})}});
  }

  void write(const health_t& message) {
    recording_.sensor(channel::kHealth).use(message.utime);
    json devices = json::array(), counters = json::object();
    for (const auto& device : message.devices)
      devices.push_back({{"name", device.name}, {"state", device.state}, {"rate", device.rate}});
    for (const auto& counter : message.counters) counters[counter.name] = counter.value;
    send("/health", "slam.health", message.utime,
         {{"summary", message.summary},
          {"localisation", message.localisation},
          {"cpu", message.cpu},
          {"memory_mb", message.memory_mb},
          {"devices", devices},
          {"counters", counters}});
  }

  void draw(const MapPicture::Picture& map, std::int64_t utime) { send("/map", "foxglove.Grid", utime, gridOf(map)); }

  static void put(std::string& points, float x, float y, float intensity) {
    for (const float value : {x, y, 0.0F, intensity}) {
      char bytes[sizeof value];
      std::memcpy(bytes, &value, sizeof value);  // both ends are little-endian
      points.append(bytes, sizeof value);
    }
  }

  void cloud(const std::string& topic, const char* frame, std::int64_t utime, const std::string& points) {
    constexpr int kFloat32 = 7;
    json fields = json::array();
    for (const char* name : {"x", "y", "z", "intensity"})
      fields.push_back({{"name", name}, {"offset", 4 * fields.size()}, {"type", kFloat32}});
    send(topic, "foxglove.PointCloud", utime,
         {{"timestamp", timeOf(utime)},
          {"frame_id", frame},
          {"pose", poseOf({})},
          {"point_stride", 16},
          {"fields", fields},
          {"data", base64(points)}});
  }

  void place(std::int64_t utime, const char* parent, const char* child, const Pose2& pose) {
    placed_ = true;
    transform(utime, parent, child, pose);
  }

  void transform(std::int64_t utime, const char* parent, const char* child, const Pose2& pose) {
    send("/tf", "foxglove.FrameTransform", utime,
         {{"timestamp", timeOf(utime)},
          {"parent_frame_id", parent},
          {"child_frame_id", child},
          {"translation", translation(pose)},
          {"rotation", rotation(pose)}});
  }

  void send(const std::string& topic, const std::string& schema, std::int64_t utime, const json& message) {
    auto at = channels_.find(topic);
    if (at == channels_.end())
      at = channels_.emplace(topic, writer_.addChannel(topic, schema, schemaOf(schema, message))).first;
    writer_.write(at->second, received_, utime, message.dump(-1, ' ', false, json::error_handler_t::replace));
  }

  McapWriter writer_;
  std::map<std::string, std::uint16_t> channels_;  // by topic
  Trajectory trajectory_;
  Pose2 T_base_lidar_, T_base_camera_;
  bool upside_down_ = false;
  std::int64_t mounted_ = 0;  // [us]
  bool placed_ = false;
};

}  // namespace

Recording convertToMcap(const std::filesystem::path& in, const std::filesystem::path& out,
                        const std::filesystem::path& trajectory) {
  return McapExport(out, trajectory).run(in);
}

}  // namespace slam
