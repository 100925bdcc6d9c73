// SPDX-License-Identifier: BSD-3-Clause
#include "tools/convert/recording.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <nlohmann/json.hpp>
#include <numbers>

#include "core/pose2.hpp"
#include "tools/common/output_file.hpp"

namespace slam {
namespace {

std::string fixed(double value, int digits) {
  char text[64];
  std::snprintf(text, sizeof(text), "%.*f", digits, value);
  return text;
}

/// A number as TOML has it, without zeros at its end.
std::string tomlNumber(double value) {
  std::string text = fixed(std::abs(value) < 5e-10 ? 0.0 : value, 9);
  text.erase(text.find_last_not_of('0') + 1);
  return text.back() == '.' ? text + "0" : text;
}

/// Text of others in one line of a comment: UTF-8, as TOML asks, without control characters.
std::string commentText(const std::string& foreign) {
  using nlohmann::json;
  auto text = json::parse(json(foreign).dump(-1, ' ', false, json::error_handler_t::replace)).get<std::string>();
  for (char& c : text) {
    if (static_cast<unsigned char>(c) < 0x20 || c == 0x7F) c = '?';
  }
  return text;
}

std::string keyLine(const char* key, double value, const char* comment) {
  return std::string(key) + " = " + tomlNumber(value) + "  # " + comment + "\n";
}

std::string driver(bool recorded) { return std::string("driver = \"") + (recorded ? "lcm" : "none") + "\"\n"; }

}  // namespace

void SensorRows::use(std::int64_t utime) {
  ++used;
  first = std::min(first, utime);
  last = std::max(last, utime);
}

SensorRows& Recording::sensor(const std::string& name) {
  for (SensorRows& rows : sensors) {
    if (rows.name == name) return rows;
  }
  sensors.push_back({.name = name});
  return sensors.back();
}

void Recording::reject(SensorRows& rows, const std::string& where, const std::string& why) {
  constexpr std::size_t kMostReasons = 16;
  ++rows.refused;
  if (rows.reasons.size() < kMostReasons || rows.reasons.contains(why)) ++rows.reasons[why];
  reject(where, why);
}

std::string Recording::doubt() const {
  for (const SensorRows& rows : sensors) {
    if (!rows.doubtful()) continue;
    const auto worst = std::max_element(rows.reasons.begin(), rows.reasons.end(),
                                        [](const auto& a, const auto& b) { return a.second < b.second; });
    return "only " + std::to_string(rows.used) + " of " + std::to_string(rows.used + rows.refused) + " rows of " +
           rows.name + " could be used (" +
           (worst == rows.reasons.end() ? std::string("damage") : commentText(worst->first)) +
           "); the log holds these and is not to be trusted; is the input what the command takes it for?";
  }
  return {};
}

std::string reportText(const Recording& recording, const std::string& out, bool details) {
  std::string text;
  if (details) {
    if (!recording.format.empty()) text += "input: " + recording.format + "\n";
    for (const SensorRows& rows : recording.sensors) {
      text += "  " + commentText(rows.name);
      if (!rows.frame.empty()) text += ", frame " + commentText(rows.frame);
      text += ": " + std::to_string(rows.used) + " used";
      const double span = rows.used > 1 ? 1e-6 * static_cast<double>(rows.last - rows.first) : 0.0;
      if (span > 0.0) text += ", " + fixed(span, 1) + " s at " + fixed((rows.used - 1) / span, 1) + " Hz";
      if (rows.refused > 0) text += ", " + std::to_string(rows.refused) + " refused";
      text += "\n";
      for (const auto& [why, count] : rows.reasons) {
        text += "    " + std::to_string(count) + " times: " + commentText(why) + "\n";
      }
    }
    for (const std::string& what : recording.unused) text += "  not used: " + commentText(what) + "\n";
    if (recording.scans > 0) {
      const RobotDescription& robot = recording.robot;
      text += "lidar on the base: x " + fixed(robot.lidar_x, 3) + " m, y " + fixed(robot.lidar_y, 3) + " m, yaw " +
              fixed(robot.lidar_yaw * 180.0 / std::numbers::pi, 1) + " deg" +
              (robot.lidar_upside_down ? ", upside down" : "") + " (" +
              (robot.mount_source.empty() ? "not recorded: set lidar.x, y and yaw in the configuration"
                                          : "from " + commentText(robot.mount_source)) +
              ")\n";
    }
  }
  for (const std::string& note : recording.notes) text += "note: " + commentText(note) + "\n";
  text += out + ": " + std::to_string(recording.scans) + " scans, " + std::to_string(recording.wheels) +
          " wheel samples, " + std::to_string(recording.imu) + " IMU samples";
  if (recording.poses > 0) text += ", " + std::to_string(recording.poses) + " poses";
  if (recording.rejected > 0) {
    text += "; " + std::to_string(recording.rejected) + " records refused, first at " +
            commentText(recording.first_rejection);
  }
  return text + "\n";
}

std::string configText(const Recording& recording, const std::string& made_by) {
  if (recording.configuration) return *recording.configuration;
  constexpr double kFarthestMount = 5.0, kSmallestRadius = 0.005, kLargestRadius = 1.0;  // [m] what slamd takes
  constexpr double kNarrowest = 0.01, kWidest = 2.0;                                     // [m] half track
  const RobotDescription& robot = recording.robot;
  std::string text = "# " + commentText(made_by) + "\n# What is not here is slamd's default: slamd --print-template\n";
  text += "\n[lidar]\n" + driver(recording.scans > 0);
  text += robot.mount_source.empty() ? "# The recording does not say where the lidar sits: measure it.\n"
                                     : "# The lidar's place is from " + commentText(robot.mount_source) + ".\n";
  text += keyLine("x", std::clamp(robot.lidar_x, -kFarthestMount, kFarthestMount), "[m] ahead of the turning centre");
  text += keyLine("y", std::clamp(robot.lidar_y, -kFarthestMount, kFarthestMount), "[m] to the left");
  text += keyLine("yaw", std::clamp(wrapAngle(robot.lidar_yaw), -3.14159265, 3.14159265), "[rad] counter-clockwise");
  if (robot.lidar_upside_down) text += "upside_down = true\n";
  if (robot.range_max) {
    const double range_max = std::clamp(*robot.range_max, 0.5, 200.0);
    text +=
        keyLine("range_min", std::clamp(robot.range_min.value_or(0.15), 0.0, std::min(10.0, 0.5 * range_max)), "[m]");
    text += keyLine("range_max", range_max, "[m]");
  }
  if (robot.range_sigma) text += keyLine("range_sigma", *robot.range_sigma, "[m]");
  text += "\n[base]\n" + driver(recording.wheels > 0);
  if (robot.wheel_radius) {
    text += keyLine("wheel_radius", std::clamp(*robot.wheel_radius, kSmallestRadius, kLargestRadius),
                    "[m] of the angles in the log");
  }
  if (robot.half_track) {
    text += keyLine("half_track", std::clamp(*robot.half_track, kNarrowest, kWidest), "[m]");
  }
  text += "\n[imu]\n" + driver(recording.imu > 0);
  text += "\n[depth]\n" + driver(false);
  return text;
}

void writeConfig(const Recording& recording, const std::string& made_by, const std::filesystem::path& file) {
  OutputFile out(file);
  out.write(configText(recording, made_by));
  out.close();
}

}  // namespace slam
