// SPDX-License-Identifier: BSD-3-Clause
#include <bit>
#include <cmath>
#include <map>
#include <memory>
#include <numbers>
#include <optional>
#include <set>
#include <stdexcept>

#include "tools/common/trajectory.hpp"
#include "tools/convert/formats.hpp"

namespace slam {
namespace {

constexpr std::uint64_t kLidar = 0x89dc5b879a5056cf;           // lidar_t and its namesakes
constexpr std::uint64_t kMaebotEncoders = 0x7d090bfb221d74f9;  // 2016
constexpr std::uint64_t kMaebotFeedback = 0x8dc5a028fca42ff9;  // 2014-15
constexpr std::uint64_t kMaebotImu = 0xed966784146237ec;       // 2016, raw counts, no time of its own
constexpr std::uint64_t kMaebotSensors = 0xc320824c265e849a;   // 2014-15, raw counts
constexpr std::uint64_t kPose = 0x1f317af1246276ac;            // pose_xyt_t

constexpr double kMetresPerTick = 8.2e-5, kHalfTrack = 0.0415;  // [m]
constexpr double kGyroCounts = 131.0;                           // per deg/s
constexpr double kAccelCounts = 16384.0;                        // per g
constexpr double kStandardGravity = 9.80665;                    // [m/s^2]

/// Big-endian fields of an LCM payload, checked against its size.
class Fields {
 public:
  explicit Fields(std::span<const std::uint8_t> data) : data_(data) {}
  std::uint64_t unsignedInteger(int bytes) {
    if (data_.size() < at_ + static_cast<std::size_t>(bytes)) {
      ok_ = false;
      return 0;
    }
    std::uint64_t value = 0;
    for (int i = 0; i < bytes; ++i) value = value << 8 | data_[at_++];
    return value;
  }
  std::int64_t int64() { return static_cast<std::int64_t>(unsignedInteger(8)); }
  std::int32_t int32() { return static_cast<std::int32_t>(unsignedInteger(4)); }
  std::int16_t int16() { return static_cast<std::int16_t>(unsignedInteger(2)); }
  float real() { return std::bit_cast<float>(static_cast<std::uint32_t>(unsignedInteger(4))); }
  double realDouble() { return std::bit_cast<double>(unsignedInteger(8)); }
  std::size_t left() const { return data_.size() - at_; }
  bool ok() const { return ok_; }

 private:
  std::span<const std::uint8_t> data_;
  std::size_t at_ = 0;
  bool ok_ = true;
};

bool readScan(Fields& fields, LaserScan& scan, std::int64_t& utime) {
  utime = fields.int64();
  const std::int32_t n = fields.int32();
  if (n < 1 || n > LaserScan::kCapacity || fields.left() != static_cast<std::size_t>(n) * 20) return false;
  scan.size = n;
  for (auto i = 0; i < n; ++i) scan.storage[static_cast<std::size_t>(i)] = {.range = fields.real()};
  // Angles grow clockwise there and counter-clockwise here.
  for (auto i = 0; i < n; ++i) {
    scan.storage[static_cast<std::size_t>(i)].bearing = static_cast<float>(wrapAngle(-fields.real()));
  }
  for (auto i = 0; i < n; ++i) {
    scan.storage[static_cast<std::size_t>(i)].time_offset =
        static_cast<float>(1e-6 * static_cast<double>(fields.int64() - utime));
  }
  for (auto i = 0; i < n; ++i) scan.storage[static_cast<std::size_t>(i)].intensity = fields.real();
  scan.stamp = fromMicroseconds(utime);
  return fields.ok() && utime > 0;
}

}  // namespace

ConvertReport convertMbot(const std::filesystem::path& in, const std::filesystem::path& out, const MbotTruth& truth) {
  // The channels' clocks differ by a constant each. The least delay between an event's time and its utime is taken as
  // no delay at all, which puts every channel on the logging computer's clock.
  std::map<std::string, std::int64_t> offset;
  {
    EventLogReader log(in);
    for (LogEvent event; log.next(event);) {
      Fields fields(event.data);
      fields.unsignedInteger(8);
      const std::int64_t delay = event.utime - fields.int64();
      const auto [at, added] = offset.emplace(event.channel, delay);
      if (!added) at->second = std::min(at->second, delay);
    }
  }

  EventLogReader log(in);
  ConvertReport report;
  LogOutput output;
  auto scan = std::make_unique<LaserScan>();
  scan->range_min = 0.15F;
  scan->range_max = 8.0F;
  Pose2 pose;
  bool have_ticks = false;
  std::int32_t last_left = 0, last_right = 0;
  std::optional<TrajectoryWriter> truth_poses;
  if (!truth.file.empty()) truth_poses.emplace(truth.file);
  for (LogEvent event; log.next(event);) {
    Fields fields(event.data);
    const std::uint64_t type = fields.unsignedInteger(8);
    const std::string where = in.filename().string() + " " + event.channel;
    if (type == kLidar) {
      std::int64_t utime = 0;
      if (!readScan(fields, *scan, utime)) {
        report.reject(where, "a scan that does not decode");
        continue;
      }
      utime += offset[event.channel];
      output.add(event.utime, *scan, utime);
      ++report.scans;
    } else if (type == kMaebotEncoders || type == kMaebotFeedback) {
      const std::int64_t utime = fields.int64() + offset[event.channel];
      const std::int32_t left = fields.int32(), right = fields.int32();
      if (!fields.ok()) {
        report.reject(where, "encoders that do not decode");
        continue;
      }
      if (have_ticks) {
        const double travel_left = kMetresPerTick * (left - last_left),
                     travel_right = kMetresPerTick * (right - last_right);
        pose = pose * exp({0.5 * (travel_left + travel_right), 0.0, (travel_right - travel_left) / (2.0 * kHalfTrack)});
      }
      have_ticks = true;
      last_left = left;
      last_right = right;
      output.add(event.utime, WheelSample{fromMicroseconds(utime), pose}, utime);
      ++report.wheels;
    } else if (type == kMaebotImu || type == kMaebotSensors) {
      fields.int64();  // not a time in the newer type: the event's own time serves
      Eigen::Vector3d accel, gyro;
      const auto value = [&] { return type == kMaebotImu ? fields.realDouble() : fields.int16(); };
      for (int i = 0; i < 3; ++i) accel[i] = value() / kAccelCounts * kStandardGravity;
      for (int i = 0; i < 3; ++i) gyro[i] = value() / kGyroCounts * std::numbers::pi / 180.0;
      if (!fields.ok() || !gyro.allFinite() || !accel.allFinite()) {
        report.reject(where, "an IMU reading that does not decode");
        continue;
      }
      output.add(event.utime, ImuSample{fromMicroseconds(event.utime), gyro, accel}, event.utime);
      ++report.imu;
    } else if (type == kPose && truth_poses && event.channel == truth.channel) {
      const std::int64_t utime = fields.int64() + offset[event.channel];
      const double x = fields.real(), y = fields.real(), theta = fields.real();
      if (!fields.ok() || !isFinite(Pose2{x, y, theta})) {
        report.reject(where, "a pose that does not decode");
        continue;
      }
      truth_poses->write(utime, {x, y, theta});
      ++report.poses;
    }
  }
  if (truth_poses) truth_poses->close();
  if (truth_poses && report.poses == 0) {
    throw std::runtime_error(in.string() + ": no pose in it on channel " + truth.channel);
  }
  if (report.scans == 0) throw std::runtime_error(in.string() + ": no lidar scan of a Maebot or MBot in it");
  output.write(out);
  return report;
}

}  // namespace slam
