// SPDX-License-Identifier: BSD-3-Clause
#include "tools/common/trajectory.hpp"

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <sstream>
#include <stdexcept>

namespace slam {

std::string secondsText(std::int64_t utime) {
  char text[32];
  std::snprintf(text, sizeof text, "%s%lld.%06lld", utime < 0 ? "-" : "", std::abs(utime / 1000000LL),
                std::abs(utime % 1000000LL));
  return text;
}

void TrajectoryWriter::write(std::int64_t utime, const Pose2& pose) {
  char row[160];
  std::snprintf(row, sizeof row, "%s %.6f %.6f 0 0 0 %.9f %.9f\n", secondsText(utime).c_str(), pose.x, pose.y,
                std::sin(pose.theta / 2.0), std::cos(pose.theta / 2.0));
  file_.write(row);
}

std::optional<Timestamp> stampOf(long double seconds) {
  if (!(std::abs(seconds) <= 4.6e9L)) return std::nullopt;
  return Timestamp(Duration(std::llround(seconds * 1e9L)));
}

Trajectory readTrajectory(const std::filesystem::path& file) {
  std::ifstream in(file);
  if (!in) throw std::runtime_error(file.string() + ": cannot read: " + std::strerror(errno));
  Trajectory trajectory;
  int number = 0;
  for (std::string line; std::getline(in, line);) {
    ++number;
    if (line.empty() || line[0] == '#') continue;
    long double t = 0.0L;  // seconds since the epoch with microseconds need more than a double's half digit
    double x, y, z, qx, qy, qz, qw;
    std::istringstream row(line);
    const bool eight = static_cast<bool>(row >> t >> x >> y >> z >> qx >> qy >> qz >> qw) && (row >> std::ws).eof();
    const auto stamp = stampOf(t);
    if (!eight || !stamp) {
      throw std::runtime_error(file.string() + ":" + std::to_string(number) +
                               ": not a TUM row; expected 't tx ty tz qx qy qz qw'");
    }
    trajectory.push_back({*stamp, {x, y, wrapAngle(2.0 * std::atan2(qz, qw))}});
  }
  if (trajectory.empty()) throw std::runtime_error(file.string() + ": no pose in it");
  std::stable_sort(trajectory.begin(), trajectory.end(),
                   [](const StampedPose& a, const StampedPose& b) { return a.stamp < b.stamp; });
  return trajectory;
}

std::optional<Pose2> poseAt(const Trajectory& trajectory, Timestamp stamp, Duration tolerance) {
  const auto after = std::lower_bound(trajectory.begin(), trajectory.end(), stamp,
                                      [](const StampedPose& row, Timestamp t) { return row.stamp < t; });
  const auto before = after == trajectory.begin() ? trajectory.end() : std::prev(after);
  const bool have_after = after != trajectory.end(), have_before = before != trajectory.end();
  const Duration gap_after = have_after ? after->stamp - stamp : Duration::max();
  const Duration gap_before = have_before ? stamp - before->stamp : Duration::max();
  if (std::min(gap_after, gap_before) <= tolerance) return (gap_after <= gap_before ? after : before)->pose;
  if (!have_after || !have_before) return std::nullopt;
  return interpolate(before->pose, after->pose, toSeconds(gap_before) / toSeconds(after->stamp - before->stamp));
}

}  // namespace slam
