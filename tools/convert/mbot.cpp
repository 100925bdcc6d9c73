// SPDX-License-Identifier: BSD-3-Clause
#include "tools/convert/mbot.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <limits>
#include <map>
#include <memory>
#include <numbers>
#include <optional>
#include <span>
#include <stdexcept>
#include <string>

#include "bus/event_log.hpp"
#include "core/samples.hpp"
#include "core/scan.hpp"
#include "estimation/wheel_odometry.hpp"
#include "tools/common/trajectory.hpp"
#include "tools/convert/beam_times.hpp"
#include "tools/convert/log_output.hpp"

namespace slam {
namespace {

constexpr std::uint64_t kMaebotEncoders = 0x7d090bfb221d74f9;  // 2016
constexpr std::uint64_t kMaebotFeedback = 0x8dc5a028fca42ff9;  // 2014-15
constexpr std::uint64_t kMaebotImu = 0xed966784146237ec;       // 2016, raw counts, no time of its own
constexpr std::uint64_t kMaebotSensors = 0xc320824c265e849a;   // 2014-15, raw counts
constexpr std::uint64_t kMbotEncoders = 0xa8b04e85ffa9d1d1;    // from 2017 on
constexpr std::uint64_t kMbotImu = 0x5d3f1ec742142382;         // from 2017 on, deg/s and m/s^2
constexpr std::uint64_t kPose = 0x1f317af1246276ac;            // pose_xyt_t

/// [m] a tick and between the wheels, as the course's software has them
struct Wheels {
  double metres_per_tick, width;
};
constexpr Wheels kMaebot2014{2.09e-4, 0.083}, kMaebot2016{8.2e-5, 0.083}, kMbot{1.540e-4, 0.210};

constexpr double kGyroCounts = 131.0;         // per deg/s
constexpr double kAccelCounts = 16384.0;      // per g
constexpr double kStandardGravity = 9.80665;  // [m/s^2]

constexpr std::int64_t kFarthestTime = std::int64_t{1} << 60;  // [us] beyond, a time is none and sums may overflow
constexpr std::size_t kMostChannels = 100;                     // that are counted

bool isTime(std::int64_t utime) { return utime > -kFarthestTime && utime < kFarthestTime; }

bool isSensor(std::uint64_t type) {
  return type == kMbotLidar || type == kMaebotEncoders || type == kMaebotFeedback || type == kMbotEncoders ||
         type == kMaebotImu || type == kMaebotSensors || type == kMbotImu;
}

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

/// @param timed its beams have times
bool readScan(Fields& fields, LaserScan& scan, std::int64_t& utime, bool& timed) {
  utime = fields.int64();
  const std::int32_t n = fields.int32();
  if (n < 1 || n > LaserScan::kCapacity || fields.left() != static_cast<std::size_t>(n) * 20) return false;
  scan.size = n;
  const std::span<Beam> beams(scan.storage.data(), static_cast<std::size_t>(n));
  for (Beam& beam : beams) {
    const float range = fields.real();
    beam = {.range = std::isfinite(range) && range > 0.0F ? range : 0.0F};
  }
  // Their bearings grow clockwise, counter-clockwise here.
  for (Beam& beam : beams) {
    const double bearing = wrapAngle(static_cast<double>(-fields.real()));
    if (!std::isfinite(bearing)) return false;
    beam.bearing = static_cast<float>(bearing);
  }
  std::array<std::int64_t, LaserScan::kCapacity> times;
  for (std::size_t i = 0; i < beams.size(); ++i) times[i] = fields.int64();
  if (!isTime(utime)) return false;
  for (Beam& beam : beams) beam.intensity = fields.real();
  // The stamp is the first beam's, whatever the writer put into utime; times far from it are none.
  constexpr std::int64_t kLongest = 2000000;  // [us]
  const auto [first, last] = std::minmax_element(times.begin(), times.begin() + n);
  timed = *first > 0 && *last < kFarthestTime && *last - *first < kLongest && std::abs(*first - utime) < kLongest;
  if (timed) utime = *first;
  for (std::size_t i = 0; i < beams.size(); ++i) {
    beams[i].time_offset = timed ? static_cast<float>(1e-6 * static_cast<double>(times[i] - utime)) : 0.0F;
  }
  return fields.ok() && utime > 0;
}

/// [us] by the logging computer's clock; 0: not a time that a message may carry
std::int64_t onOneClock(std::int64_t utime, std::int64_t offset) {
  if (!isTime(utime)) return 0;
  const std::int64_t moved = utime + offset;
  return moved > 0 && moved < std::numeric_limits<std::int64_t>::max() / 4000 ? moved : 0;
}

/// [s] from the scan's stamp to its last beam
double duration(const LaserScan& scan) {
  double longest = 0.0;
  for (const Beam& beam : scan.beams()) longest = std::max(longest, static_cast<double>(beam.time_offset));
  return longest;
}

}  // namespace

Recording convertMbot(const std::filesystem::path& in, const std::filesystem::path& out, const MbotTruth& truth,
                      const MbotBase& base) {
  // The channels' clocks differ by a constant each. The least delay between an event's time and its utime is taken as
  // no delay at all, which puts every channel on the logging computer's clock.
  std::map<std::string, std::int64_t> offset;
  auto scan = std::make_unique<LaserScan>();
  scan->range_min = 0.15F;
  scan->range_max = 8.0F;
  bool encoders = false, timed = false;
  BeamTimes beam_times;
  {
    EventLogReader log(in);
    for (LogEvent event; log.next(event);) {
      Fields fields(event.data);
      const std::uint64_t type = fields.unsignedInteger(8);
      encoders |= type == kMaebotEncoders || type == kMaebotFeedback || type == kMbotEncoders;
      std::int64_t utime = 0;
      if (type == kMbotLidar) {
        if (!readScan(fields, *scan, utime, timed)) continue;
        const std::int64_t last = utime + std::llround(1e6 * duration(*scan));
        if (timed) beam_times.add(utime, last);
        utime = last;  // a scan is sent when its last beam is there
      } else {
        utime = fields.int64();
      }
      if (!isTime(event.utime) || !isTime(utime)) continue;
      const std::int64_t delay = event.utime - utime;
      const auto [at, added] = offset.emplace(event.channel, delay);
      if (!added) at->second = std::min(at->second, delay);
    }
  }

  EventLogReader log(in);
  Recording recording;
  recording.format = "LCM log of a Maebot or MBot";
  const auto copied_turn = beam_times.copiedTurn();
  if (copied_turn) recording.notes.push_back(noteOfCopiedTurns(*copied_turn));
  LogOutput output;
  Pose2 pose;
  std::optional<std::array<std::int64_t, 2>> last;
  const double wheel_radius = base.wheel_radius.value_or(DifferentialBase{}.wheel_radius);
  std::map<std::string, int> others;
  std::optional<TrajectoryWriter> truth_poses;
  if (!truth.file.empty()) truth_poses.emplace(truth.file);
  for (LogEvent event; log.next(event);) {
    Fields fields(event.data);
    const std::uint64_t type = fields.unsignedInteger(8);
    const std::string where = in.filename().string() + " " + event.channel;
    SensorRows ignored;
    const bool sensor = isSensor(type) || (type == kPose && !encoders && event.channel.ends_with("ODOMETRY"));
    SensorRows& rows = sensor ? recording.sensor(event.channel) : ignored;
    if (type == kMbotLidar) {
      std::int64_t utime = 0;
      const bool decoded = readScan(fields, *scan, utime, timed);
      if (decoded && timed && copied_turn) {
        utime -= *copied_turn;
        for (int i = 0; i < scan->size; ++i) scan->storage[static_cast<std::size_t>(i)].time_offset = 0.0F;
      }
      if (!decoded || (utime = onOneClock(utime, offset[event.channel])) == 0) {
        recording.reject(rows, where, "a scan that does not decode");
        continue;
      }
      scan->stamp = fromMicroseconds(utime);
      output.add(event.utime, *scan, utime);
      recording.useScan(rows, utime);
    } else if (type == kMaebotEncoders || type == kMaebotFeedback || type == kMbotEncoders) {
      const std::int64_t utime = onOneClock(fields.int64(), offset[event.channel]);
      const bool wide = type == kMbotEncoders;
      const std::int64_t left = wide ? fields.int64() : fields.int32(), right = wide ? fields.int64() : fields.int32();
      constexpr std::int64_t kMostTicks = std::int64_t{1} << 52;  // more are none
      if (!fields.ok() || utime <= 0 || std::min(left, right) < -kMostTicks || std::max(left, right) > kMostTicks) {
        recording.reject(rows, where, "encoders that do not decode");
        continue;
      }
      const Wheels& year = wide ? kMbot : type == kMaebotEncoders ? kMaebot2016 : kMaebot2014;
      const double metres_per_tick = base.metres_per_tick.value_or(year.metres_per_tick);
      const double half_track = 0.5 * base.width.value_or(year.width);
      if (last) {
        const double travel_left = metres_per_tick * static_cast<double>(left - (*last)[0]),
                     travel_right = metres_per_tick * static_cast<double>(right - (*last)[1]);
        pose = pose * exp({0.5 * (travel_left + travel_right), 0.0, (travel_right - travel_left) / (2.0 * half_track)});
      }
      last = {left, right};
      const double radians_per_tick = metres_per_tick / wheel_radius;
      output.add(
          event.utime, WheelSample{fromMicroseconds(utime), pose}, utime,
          std::array{static_cast<double>(left) * radians_per_tick, static_cast<double>(right) * radians_per_tick});
      recording.useWheels(rows, utime);
      recording.robot.wheel_radius = wheel_radius;
      recording.robot.half_track = half_track;
    } else if (type == kMaebotImu || type == kMaebotSensors) {
      fields.int64();  // not a time in the newer type: the event's own time serves
      Eigen::Vector3d accel, gyro;
      const auto value = [&] { return type == kMaebotImu ? fields.realDouble() : fields.int16(); };
      for (int i = 0; i < 3; ++i) accel[i] = value() / kAccelCounts * kStandardGravity;
      for (int i = 0; i < 3; ++i) gyro[i] = value() / kGyroCounts * std::numbers::pi / 180.0;
      const std::int64_t utime = onOneClock(event.utime, 0);
      if (!fields.ok() || utime <= 0 || !gyro.allFinite() || !accel.allFinite()) {
        recording.reject(rows, where, "an IMU reading that does not decode");
        continue;
      }
      output.add(event.utime, ImuSample{fromMicroseconds(utime), gyro, accel}, utime);
      recording.useImu(rows, utime);
    } else if (type == kMbotImu) {
      const std::int64_t utime = onOneClock(fields.int64(), offset[event.channel]);
      Eigen::Vector3d gyro, accel;
      for (int i = 0; i < 3; ++i) gyro[i] = static_cast<double>(fields.real()) * std::numbers::pi / 180.0;
      for (int i = 0; i < 3; ++i) accel[i] = fields.real();
      if (!fields.ok() || utime <= 0 || !gyro.allFinite() || !accel.allFinite()) {
        recording.reject(rows, where, "an IMU reading that does not decode");
        continue;
      }
      output.add(event.utime, ImuSample{fromMicroseconds(utime), gyro, accel}, utime);
      recording.useImu(rows, utime);
    } else if (type == kPose && !encoders && (event.channel == "ODOMETRY" || event.channel == "MBOT_ODOMETRY")) {
      const std::int64_t utime = onOneClock(fields.int64(), offset[event.channel]);
      const double x = fields.real(), y = fields.real(), theta = fields.real();
      if (!fields.ok() || utime <= 0 || !isFinite(Pose2{x, y, theta})) {
        recording.reject(rows, where, "odometry that does not decode");
        continue;
      }
      output.add(event.utime, WheelSample{fromMicroseconds(utime), {x, y, theta}}, utime);
      recording.useWheels(rows, utime);
    } else if (type == kPose && truth_poses && event.channel == truth.channel) {
      const std::int64_t utime = onOneClock(fields.int64(), offset[event.channel]);
      const double x = fields.real(), y = fields.real(), theta = fields.real();
      if (!fields.ok() || utime <= 0 || !isFinite(Pose2{x, y, theta})) {
        recording.reject(where, "a pose that does not decode");
        continue;
      }
      truth_poses->write(utime, {x, y, theta});
      ++recording.poses;
    } else if (others.size() < kMostChannels || others.contains(event.channel)) {
      ++others[event.channel];
    }
  }
  if (truth_poses) truth_poses->close();
  if (truth_poses && recording.poses == 0) {
    throw std::runtime_error(in.string() + ": no pose in it on channel " + truth.channel);
  }
  if (recording.scans == 0) throw std::runtime_error(in.string() + ": no lidar scan of a Maebot or MBot in it");
  for (const auto& [channel, count] : others) {
    recording.unused.push_back(channel + ", " + std::to_string(count) + " messages: of a kind that is not read");
  }
  recording.robot.range_min = 0.15;
  recording.robot.range_max = 8.0;
  recording.robot.range_sigma = 0.02;
  recording.robot.mount_source = "the course's software, which has it at the turning centre";
  output.write(out, &recording);
  return recording;
}

}  // namespace slam
