// SPDX-License-Identifier: BSD-3-Clause
#include "tools/slamctl/setup/drive_pictures.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <vector>

#include "bus/channels.hpp"
#include "bus/event_log.hpp"
#include "bus/received.hpp"
#include "core/pose_history.hpp"
#include "estimation/wheel_odometry.hpp"
#include "matching/deskew.hpp"
#include "store/durable_file.hpp"
#include "tools/replay/replay.hpp"

namespace slam {
namespace {

constexpr int kSide = 500;                       // [pixels] of each picture's longer side
constexpr float kFarthest = 8.0F;                // [m] further returns show nothing of the wheels
constexpr std::uint64_t kMostPicture = 1 << 24;  // [bytes]
constexpr Rgb kPaper{255, 255, 255}, kInk{30, 40, 60};

/// Poses of the base by its wheels' angles alone.
PoseHistory reckon(const DifferentialBase& base, const std::filesystem::path& log) {
  std::vector<StampedPose> poses;
  WheelOdometry odometry(base);
  EventLogReader reader(log);
  for (LogEvent event; reader.next(event);) {
    if (event.channel != channel::kWheels) continue;
    const Received<wheels_t> wheels(event.data);
    if (!wheels || wheels.message->nwheels < 2) continue;
    poses.push_back({wheels.sample->stamp, odometry.add(wheels.message->angles[0], wheels.message->angles[1])});
  }
  PoseHistory history(std::max<std::size_t>(poses.size(), 1));
  for (const StampedPose& pose : poses) history.push(pose.stamp, pose.pose);
  return history;
}

/// Returns in the wheels' frame [m].
std::vector<Eigen::Vector2d> returnsOf(const Config& config, const std::filesystem::path& log) {
  const PoseHistory history = reckon(config.base_device.geometry, log);
  std::vector<Eigen::Vector2d> returns;
  ScanPoints points;
  EventLogReader reader(log);
  for (LogEvent event; reader.next(event);) {
    if (event.channel != channel::kScan) continue;
    const Received<scan_t> scan(event.data);
    if (!scan) continue;
    const auto T_wheels_base = history.at(scan.sample->stamp);
    if (!T_wheels_base) continue;
    const RangeLimits limits{scan.sample->range_min, std::min(scan.sample->range_max, kFarthest)};
    deskew(*scan.sample, limits, scan.sample->stamp, config.front_end.lidar.mounting(), history, points);
    for (const ScanPoint& point : points) returns.push_back(*T_wheels_base * point.position);
  }
  return returns;
}

}  // namespace

ColourImage scansOverWheels(const Config& left, const Config& right, const std::filesystem::path& log) {
  const std::vector<Eigen::Vector2d> both[] = {returnsOf(left, log), returnsOf(right, log)};
  if (both[0].empty() || both[1].empty()) return {};
  Eigen::AlignedBox2d box;
  for (const auto& points : both) {
    for (const Eigen::Vector2d& point : points) box.extend(point);
  }
  const double pixel = std::max(box.sizes().maxCoeff(), 1.0) / (kSide - 1);  // [m]
  ColourImage pictures[2];
  for (std::size_t i = 0; i < 2; ++i) {
    ColourImage& picture = pictures[i];
    picture.width = 1 + static_cast<int>(box.sizes().x() / pixel);
    picture.height = 1 + static_cast<int>(box.sizes().y() / pixel);
    picture.pixels.assign(static_cast<std::size_t>(picture.width) * static_cast<std::size_t>(picture.height), kPaper);
    for (const Eigen::Vector2d& point : both[i]) {
      const Eigen::Vector2d at = (point - box.min()) / pixel;
      picture.set(static_cast<int>(at.x()), picture.height - 1 - static_cast<int>(at.y()), kInk);
    }
  }
  return sideBySide(pictures[0], pictures[1]);
}

std::string mapOfDrive(const Config& config, const std::filesystem::path& log, const std::filesystem::path& folder) {
  ReplayOptions options;
  options.logs = {log};
  options.map = folder / "drive";
  replay(config, options);
  return readFile(folder / "drive.png", kMostPicture);
}

}  // namespace slam
