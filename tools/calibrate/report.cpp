// SPDX-License-Identifier: BSD-3-Clause
#include "tools/calibrate/report.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdarg>
#include <cstdio>
#include <numbers>
#include <vector>

namespace slam {
namespace {

constexpr double kInterval = 1.96;  // [1] sigmas to either side that hold 95 %
constexpr double kDegree = std::numbers::pi / 180.0;

constexpr double kManyRejected = 0.3;  // [1] of the motions
constexpr double kMuchNoise = 5.0;     // [1] residuals against the matches' claims
constexpr double kMuchMoved = 0.02;    // [m] of the lidar against its configured place ...
constexpr double kMuchTurned = 0.05;   // [rad] ... and yaw

struct Row {
  const char* name;
  const char* key;  // of the JSON
};
constexpr std::array<Row, 6> kRows{{{"left wheel radius [m]", "left_radius_m"},
                                    {"right wheel radius [m]", "right_radius_m"},
                                    {"track [m]", "track_m"},
                                    {"lidar x [m]", "lidar_x_m"},
                                    {"lidar y [m]", "lidar_y_m"},
                                    {"lidar yaw [rad]", "lidar_yaw_rad"}}};

[[gnu::format(printf, 1, 2)]] std::string format(const char* text, ...) {
  char line[512];
  std::va_list arguments;
  va_start(arguments, text);
  std::vsnprintf(line, sizeof line, text, arguments);
  va_end(arguments);
  return line;
}

struct Value {
  double value, sigma;
};

bool radiiDetermined(const Calibration& c) {
  return c.determined[RobotGeometry::kLeftRadius] && c.determined[RobotGeometry::kRightRadius];
}

/// left / right
Value radiusRatio(const Calibration& c) {
  const double ratio = c.geometry.left_radius / c.geometry.right_radius;
  const Eigen::Vector2d J(1.0 / c.geometry.right_radius, -ratio / c.geometry.right_radius);
  return {ratio, std::sqrt(J.dot(c.covariance.topLeftCorner<2, 2>() * J))};
}

std::string ratioInWords(const Calibration& c) {
  const auto [ratio, sigma] = radiusRatio(c);
  const double difference = std::abs(ratio - 1.0);
  if (difference < kInterval * sigma) {
    return format("The wheels are equally large as far as the data show: left / right = %.5f +- %.5f (95 %%).\n", ratio,
                  kInterval * sigma);
  }
  const double drift = difference * c.geometry.right_radius /
                       (0.5 * (c.geometry.left_radius + c.geometry.right_radius) * c.geometry.track);
  return format(
      "The %s wheel is larger by %.2f %% +- %.2f %% (95 %%): left / right = %.5f. slamd knows one radius for both, so "
      "the "
      "wheels alone will still turn by %.2f deg a metre too much to the %s.\n",
      ratio > 1.0 ? "left" : "right", 100.0 * difference, 100.0 * kInterval * sigma, ratio, drift / kDegree,
      ratio > 1.0 ? "left" : "right");
}

std::vector<std::string> openParameters(const Calibration& c) {
  std::vector<std::string> open;
  for (std::size_t i = 0; i < kRows.size(); ++i) {
    if (!c.determined[i]) open.emplace_back(kRows[i].name);
  }
  return open;
}

/// Where the motions disagree by more than chance.
std::string warning(const Calibration& c) {
  const bool many = c.rejected > kManyRejected * (c.used + c.rejected);
  if (!many && std::max(c.translation_noise, c.rotation_noise) < kMuchNoise) return {};
  return format(
      "Wheels and lidar disagree by much: %d of %d motions rejected, residuals of the rest %.1f (translation) and %.1f "
      "(rotation) times what the matches claim. Slip, wrong matches, or lidar stamps that are off (lidar.time_offset)? "
      "The intervals may be too narrow.\n",
      c.rejected, c.used + c.rejected, c.translation_noise, c.rotation_noise);
}

bool lidarMoved(const CalibrationReport& report) {
  const Pose2 moved = between(report.configured.T_base_lidar, report.result.geometry.T_base_lidar);
  return moved.translation().norm() > kMuchMoved || std::abs(moved.theta) > kMuchTurned;
}

std::string remarks(const CalibrationReport& report) {
  std::string text;
  const auto open = openParameters(report.result);
  if (!open.empty()) {
    text += "Not determined by this log:";
    for (std::size_t i = 0; i < open.size(); ++i) text += (i > 0 ? ", " : " ") + open[i].substr(0, open[i].find(" ["));
    text += std::string(": ") + describe(report.result.drive) + ".\n";
  }
  text += warning(report.result);
  if (lidarMoved(report)) {
    text +=
        "The lidar sits elsewhere than configured, which bends the scans of a moving robot a little: take the values "
        "over "
        "and run again.\n";
  }
  if (radiiDetermined(report.result)) text += ratioInWords(report.result);
  if (!report.angles_recorded) {
    text +=
        "The log has no wheel angles: they were taken back from its dead reckoning by the configured wheel radius and "
        "half track. The values hold if the dead reckoning was made with the same; else only their ratio to the "
        "configured ones does.\n";
  }
  return text;
}

/// `key = value`, as a comment where the value is not determined.
std::string setting(const char* key, double value, bool determined) {
  return determined ? format("%s = %.6g\n", key, value) : format("# %s: not determined\n", key);
}

std::string settings(const Calibration& c) {
  const RobotGeometry& g = c.geometry;
  return "[base]\n" + setting("wheel_radius", 0.5 * (g.left_radius + g.right_radius), radiiDetermined(c)) +
         setting("half_track", 0.5 * g.track, c.determined[RobotGeometry::kTrack]) + "\n[lidar]\n" +
         setting("x", g.T_base_lidar.x, c.determined[RobotGeometry::kLidarX]) +
         setting("y", g.T_base_lidar.y, c.determined[RobotGeometry::kLidarY]) +
         setting("yaw", g.T_base_lidar.theta, c.determined[RobotGeometry::kLidarYaw]);
}

std::string quoted(const std::string& text) {
  std::string quoted = "\"";
  for (const char c : text)
    quoted += c == '\n' ? std::string("\\n") : c == '"' ? std::string("\\\"") : std::string(1, c);
  return quoted + "\"";
}

}  // namespace

std::string CalibrationReport::table() const {
  std::string text = format("%d motions used, %d rejected; RMS residual %.1f mm, %.3f deg\n\n", result.used,
                            result.rejected, 1e3 * result.translation_residual, result.rotation_residual / kDegree);
  text += format("%-24s %11s %11s %9s   %s\n", "parameter", "configured", "estimated", "1 sigma", "95 % interval");
  const auto before = configured.vector(), after = result.geometry.vector();
  for (int i = 0; i < 6; ++i) {
    const auto row = static_cast<std::size_t>(i);
    if (!result.determined[row]) {
      text += format("%-24s %11.5f   not determined\n", kRows[row].name, before[i]);
      continue;
    }
    const double sigma = result.sigma(static_cast<RobotGeometry::Index>(i));
    text += format("%-24s %11.5f %11.5f %9.5f   %.5f to %.5f\n", kRows[row].name, before[i], after[i], sigma,
                   after[i] - kInterval * sigma, after[i] + kInterval * sigma);
  }
  return text + "\n" + remarks(*this) + "\n" + settings(result);
}

std::string CalibrationReport::json() const {
  std::string text = format(
      "{\"motions\": {\"used\": %d, \"rejected\": %d}, \"residual\": {\"translation_m\": %.6f, \"rotation_rad\": "
      "%.7f},\n"
      " \"wheel_angles\": \"%s\",\n \"parameters\": {",
      result.used, result.rejected, result.translation_residual, result.rotation_residual,
      angles_recorded ? "recorded" : "from dead reckoning");
  const auto before = configured.vector(), after = result.geometry.vector();
  for (int i = 0; i < 6; ++i) {
    const auto row = static_cast<std::size_t>(i);
    text += format("%s\n  \"%s\": {\"configured\": %.7f, ", i > 0 ? "," : "", kRows[row].key, before[i]);
    const double sigma = result.sigma(static_cast<RobotGeometry::Index>(i));
    text += result.determined[row] ? format(
                                         "\"determined\": true, \"estimated\": %.7f, \"sigma\": %.7f, "
                                         "\"interval_95\": [%.7f, %.7f]}",
                                         after[i], sigma, after[i] - kInterval * sigma, after[i] + kInterval * sigma)
                                   : std::string("\"determined\": false}");
  }
  text += "\n },\n";
  if (radiiDetermined(result)) {
    const auto [ratio, sigma] = radiusRatio(result);
    text += format(" \"radius_left_over_right\": {\"value\": %.7f, \"sigma\": %.7f},\n", ratio, sigma);
  }
  return text + " \"remarks\": " + quoted(remarks(*this)) + ",\n \"toml\": " + quoted(settings(result)) + "}\n";
}

}  // namespace slam
