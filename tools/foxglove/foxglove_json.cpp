// SPDX-License-Identifier: BSD-3-Clause
#include "tools/foxglove/foxglove_json.hpp"

#include <cmath>
#include <nlohmann/json.hpp>

namespace slam::foxglove {
namespace {

using nlohmann::json;

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

const char* kindOf(const json& value) {
  return value.is_number_float()     ? "number"
         : value.is_number_integer() ? "integer"
         : value.is_boolean()        ? "boolean"
         : value.is_string()         ? "string"
                                     : "object";
}

}  // namespace

json pointCloud(const char* frame, std::int64_t utime, std::string_view points) {
  constexpr int kFloat32 = 7;
  json fields = json::array();
  for (const char* name : {"x", "y", "z", "intensity"})
    fields.push_back({{"name", name}, {"offset", 4 * fields.size()}, {"type", kFloat32}});
  return {{"timestamp", timeOf(utime)}, {"frame_id", frame},           {"pose", poseOf({})},
          {"point_stride", 16},         {"fields", std::move(fields)}, {"data", base64(points)}};
}

json poseInFrame(const char* frame, std::int64_t utime, const Pose2& pose) {
  return {{"timestamp", timeOf(utime)}, {"frame_id", frame}, {"pose", poseOf(pose)}};
}

json frameTransform(std::int64_t utime, const char* parent, const char* child, const Pose2& pose) {
  return {{"timestamp", timeOf(utime)},
          {"parent_frame_id", parent},
          {"child_frame_id", child},
          {"translation", translation(pose)},
          {"rotation", rotation(pose)}};
}

json grid(const MapPicture::Picture& map) {
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

json log(std::int64_t utime, const problem_t& problem) {
  constexpr int kWarning = 3, kError = 4;
  std::string words = problem.cause;
  for (const std::string& more : {problem.meanwhile, problem.fix}) words += more.empty() ? "" : "; " + more;
  return {{"timestamp", timeOf(utime)}, {"level", problem.level > 1 ? kError : kWarning},
          {"message", words},           {"name", problem.device},
          {"file", problem.id},         {"line", 0}};
}

json estimate(const pose_estimate_t& message) {
  return {{"x", message.x},
          {"y", message.y},
          {"theta", message.theta},
          {"covariance", message.covariance},
          {"twist", message.twist},
          {"state", message.state},
          {"match_quality", message.match_quality},
          {"map_id", message.map_id}};
}

json wheels(const wheels_t& message) {
  return {{"x", message.x},
          {"y", message.y},
          {"theta", message.theta},
          {"turn_rate_known", message.turn_rate_known != 0},
          {"angles", message.angles}};
}

json imu(const imu_t& message) { return {{"gyro", message.gyro}, {"accel", message.accel}}; }

json health(const health_t& message) {
  json devices = json::array(), counters = json::object();
  for (const auto& device : message.devices)
    devices.push_back({{"name", device.name}, {"state", device.state}, {"rate", device.rate}});
  for (const auto& counter : message.counters) counters[counter.name] = counter.value;
  return {{"summary", message.summary},     {"localisation", message.localisation}, {"cpu", message.cpu},
          {"memory_mb", message.memory_mb}, {"devices", std::move(devices)},        {"counters", std::move(counters)}};
}

std::string schemaOf(const std::string& name, const json& message) {
  json properties = json::object();
  for (const auto& [field, value] : message.items()) {
    // Lists that may be empty are those of a base's angles, and of devices.
    const json item = value.is_array() && !value.empty() ? value.front()
                      : field == "devices"               ? json::object()
                                                         : json(0.0);
    properties[field] =
        value.is_array() ? json{{"type", "array"}, {"items", {{"type", kindOf(item)}}}} : json{{"type", kindOf(value)}};
  }
  return json{{"title", name}, {"type", "object"}, {"properties", properties}}.dump();
}

}  // namespace slam::foxglove
