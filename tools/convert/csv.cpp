// SPDX-License-Identifier: BSD-3-Clause
#include <cmath>
#include <functional>
#include <memory>
#include <numbers>
#include <stdexcept>

#include "tools/convert/formats.hpp"
#include "tools/convert/text_file.hpp"

namespace slam {
namespace {

constexpr double kStandardGravity = 9.80665;  // [m/s^2]
constexpr std::int64_t kEpoch = 1000000;      // [us] added to stamps: a recording that begins at 0 has no stamp of 0

/// Calls row(utime, words) for each line with `columns` or more words; the header and comments are passed over.
void forEachRow(const std::filesystem::path& path, std::size_t columns, ConvertReport& report,
                const std::function<bool(std::int64_t, const std::vector<std::string_view>&)>& row) {
  TextFile file(path);
  for (std::string line; file.next(line);) {
    const auto words = splitWords(line);
    if (words.empty() || words[0].front() == '#') continue;
    if (file.lineNumber() == 1 && !toNumber(words[0])) continue;
    const auto utime = toMicroseconds(words[0]);
    if (!utime || words.size() < columns || !row(*utime + kEpoch, words)) {
      report.reject(path.filename().string() + ":" + std::to_string(file.lineNumber()), "not a row of numbers");
    }
  }
  reportDamage(file, path, report);
}

}  // namespace

ConvertReport convertCsv(const CsvInput& in, const std::filesystem::path& out) {
  ConvertReport report;
  LogOutput log;
  if (!in.speed.empty()) {
    Pose2 pose;
    std::int64_t previous = -1;
    forEachRow(in.speed, 2, report, [&](std::int64_t utime, const auto& words) {
      const auto speed = toNumber(words[1]);
      if (!speed) return false;
      // The speed is the mean since the row before it; there is no turn rate.
      if (previous >= 0) pose.x += *speed * static_cast<double>(utime - previous) * 1e-6;
      previous = utime;
      log.add(utime, WheelSample{fromMicroseconds(utime), pose, false}, utime);
      return ++report.wheels > 0;
    });
  }
  if (!in.encoders.empty()) {
    Pose2 pose;
    forEachRow(in.encoders, 5, report, [&](std::int64_t utime, const auto& words) {
      const auto ticks = toNumbers(words, 1);
      if (!ticks) return false;
      const double right = 0.5 * ((*ticks)[0] + (*ticks)[2]) * in.metres_per_tick;
      const double left = 0.5 * ((*ticks)[1] + (*ticks)[3]) * in.metres_per_tick;
      pose = pose * exp({0.5 * (left + right), 0.0, (right - left) / (2.0 * in.half_track)});
      log.add(utime, WheelSample{fromMicroseconds(utime), pose}, utime);
      return ++report.wheels > 0;
    });
  }
  if (!in.imu.empty()) {
    forEachRow(in.imu, 7, report, [&](std::int64_t utime, const auto& words) {
      Eigen::Vector3d accel, gyro;
      for (int i = 0; i < 3; ++i) {
        const auto a = toNumber(words[static_cast<std::size_t>(1 + i)]);
        const auto w = toNumber(words[static_cast<std::size_t>(4 + i)]);
        if (!a || !w) return false;
        accel[i] = *a * kStandardGravity;
        gyro[i] = *w;
      }
      gyro.z() *= in.imu_sign_z;
      accel.z() *= in.imu_sign_z;
      log.add(utime, ImuSample{fromMicroseconds(utime), gyro, accel}, utime);
      return ++report.imu > 0;
    });
  }
  if (!in.scans.empty()) {
    auto scan = std::make_unique<LaserScan>();
    scan->range_min = 0.1F;
    scan->range_max = 80.0F;
    forEachRow(in.scans, 3, report, [&](std::int64_t utime, const auto& words) {
      constexpr int kRangeMask = 8191, kNone = 8191;
      const std::size_t beams = words.size() - 1;
      if (beams < 2 || beams > LaserScan::kCapacity) return false;
      scan->stamp = fromMicroseconds(utime);
      scan->size = 0;
      for (std::size_t i = 0; i < beams; ++i) {
        const auto number = toNumber(words[i + 1]);
        if (!number || *number < 0 || *number > 65535) return false;
        const int word = static_cast<int>(*number), centimetres = word & kRangeMask;
        const double bearing = std::numbers::pi * (static_cast<double>(i) / static_cast<double>(beams - 1) - 0.5);
        scan->push({.range = centimetres == kNone ? 0.0F : static_cast<float>(centimetres) * 0.01F,
                    .bearing = static_cast<float>(bearing),
                    .intensity = static_cast<float>(word >> 13)});
      }
      log.add(utime, *scan, utime);
      return ++report.scans > 0;
    });
  }
  log.write(out);
  return report;
}

}  // namespace slam
