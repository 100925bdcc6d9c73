// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <numbers>
#include <optional>
#include <span>
#include <stdexcept>
#include <string>

#include "bus/channels.hpp"
#include "bus/event_log.hpp"
#include "core/scan.hpp"
#include "estimation/wheel_odometry.hpp"
#include "tools/common/trajectory.hpp"
#include "tools/convert/assembler.hpp"
#include "tools/convert/formats.hpp"
#include "tools/convert/wire_reader.hpp"

namespace slam {
namespace {

constexpr std::uint64_t kMbotLidar = 0x89dc5b879a5056cf;
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

constexpr double kGyroCounts = 131.0;                          // per deg/s
constexpr double kAccelCounts = 16384.0;                       // per g
constexpr std::int64_t kFarthestTime = std::int64_t{1} << 60;  // [us] beyond, a time is none and sums may overflow

bool isTime(std::int64_t utime) { return utime > -kFarthestTime && utime < kFarthestTime; }

bool isEncoders(std::uint64_t type) {
  return type == kMaebotEncoders || type == kMaebotFeedback || type == kMbotEncoders;
}
bool isImu(std::uint64_t type) { return type == kMaebotImu || type == kMaebotSensors || type == kMbotImu; }

/// The fields of an LCM payload.
struct Fields : WireReader {
  explicit Fields(std::span<const std::uint8_t> data) : WireReader(data, false, true) {}
  std::int64_t int64() { return number<std::int64_t>(); }
  float real() { return number<float>(); }
};

/// @param timed its beams have times
bool readScan(Fields& fields, LaserScan& scan, std::int64_t& utime, bool& timed) {
  utime = fields.int64();
  const std::int32_t n = fields.number<std::int32_t>();
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

class Mbot : public Reader {
 public:
  Mbot(const std::filesystem::path& in, const MbotTruth& truth, const MbotBase& base)
      : Reader(in, 0.15F, 8.0F), truth_(truth), base_(base) {}

  void read(Assembler& to) override {
    EventLogReader log(in_);
    for (LogEvent event; log.next(event);) {
      Fields fields(event.data);
      const std::uint64_t type = fields.number<std::uint64_t>();
      const Origin at{
          .sensor = event.channel, .where = in_.filename().string() + " " + event.channel, .received = event.utime};
      if (to.surveying()) {
        survey(type, fields, at, to);
      } else if (type == kMbotLidar) {
        scan(fields, at, to);
      } else if (isEncoders(type)) {
        encoders(type, fields, at, to);
      } else if (isImu(type)) {
        imu(type, fields, at, to);
      } else if (type != kPose || !pose(fields, at, to)) {
        constexpr std::size_t kMostChannels = 100;
        to.passOver(event.channel, kMostChannels);
      }
    }
  }

  void decide(Assembler& to) override {
    to.recording.format = "LCM log of a Maebot or MBot";
    if (!truth_.file.empty()) truth_poses_.emplace(truth_.file);
  }

  void finish(Assembler& to) override {
    if (truth_poses_) truth_poses_->close();
    if (truth_poses_ && to.recording.poses == 0) {
      throw std::runtime_error(in_.string() + ": no pose in it on channel " + truth_.channel);
    }
    if (to.recording.scans == 0) throw std::runtime_error(in_.string() + ": no lidar scan of a Maebot or MBot in it");
    to.noteChannels();
    RobotDescription& robot = to.recording.robot;
    robot.range_min = 0.15;
    robot.range_max = 8.0;
    robot.range_sigma = 0.02;
    robot.mount_source = "the course's software, which has it at the turning centre";
  }

 private:
  /// The channels' clocks differ by a constant each. The least delay puts each on the logging computer's clock.
  void survey(std::uint64_t type, Fields& fields, const Origin& at, Assembler& to) {
    has_encoders_ |= isEncoders(type);
    std::int64_t sent = 0;
    bool timed = false;
    if (type == kMbotLidar) {
      if (!readScan(fields, *scan_, sent, timed)) return;
      Origin beams = at;
      beams.stamp = sent;
      to.scan(beams, *scan_, {.timed = timed});
      sent += spanOf(*scan_);  // a scan is sent when its last beam is there
    } else {
      sent = fields.int64();
    }
    if (isTime(at.received) && isTime(sent)) delays_[at.sensor].add(at.received - sent);
  }

  /// [us] by the logging computer's clock; 0: not a time that a message may carry
  static std::int64_t onOneClock(std::int64_t utime, std::int64_t delay) {
    if (!isTime(utime)) return 0;
    const std::int64_t moved = utime + delay;
    return moved > 0 && moved < std::numeric_limits<std::int64_t>::max() / 4000 ? moved : 0;
  }

  std::int64_t delayOf(const std::string& channel) const {
    const auto at = delays_.find(channel);
    return at == delays_.end() ? 0 : at->second.least;
  }

  void scan(Fields& fields, Origin at, Assembler& to) {
    bool timed = false;
    const bool decoded = readScan(fields, *scan_, at.stamp, timed);
    if (!decoded || (at.stamp = onOneClock(at.stamp, delayOf(at.sensor))) == 0) {
      return to.refuse(at, "a scan that does not decode");
    }
    to.scan(at, *scan_, {.timed = timed});
  }

  void encoders(std::uint64_t type, Fields& fields, Origin at, Assembler& to) {
    at.stamp = onOneClock(fields.int64(), delayOf(at.sensor));
    std::array<std::int64_t, 2> ticks{};  // left and right
    for (std::int64_t& count : ticks) count = type == kMbotEncoders ? fields.int64() : fields.number<std::int32_t>();
    constexpr std::int64_t kMostTicks = std::int64_t{1} << 52;  // more are none
    if (!fields.ok() || at.stamp <= 0 || std::min(ticks[0], ticks[1]) < -kMostTicks ||
        std::max(ticks[0], ticks[1]) > kMostTicks) {
      return to.refuse(at, "encoders that do not decode");
    }
    const Wheels& year = type == kMbotEncoders ? kMbot : type == kMaebotEncoders ? kMaebot2016 : kMaebot2014;
    const double metres_per_tick = base_.metres_per_tick.value_or(year.metres_per_tick);
    const double half_track = 0.5 * base_.width.value_or(year.width);
    const double wheel_radius = base_.wheel_radius.value_or(DifferentialBase{}.wheel_radius);
    const double radians_per_tick = metres_per_tick / wheel_radius;
    const std::array<std::int64_t, 2> last = last_ticks_.value_or(ticks);
    if (last_ticks_) {
      pose_ = pose_ * travelled(metres_per_tick * static_cast<double>(ticks[0] - last[0]),
                                metres_per_tick * static_cast<double>(ticks[1] - last[1]), half_track);
    }
    last_ticks_ = ticks;
    to.wheels(
        at, pose_,
        std::array{static_cast<double>(ticks[0]) * radians_per_tick, static_cast<double>(ticks[1]) * radians_per_tick});
    to.recording.robot.wheel_radius = wheel_radius;
    to.recording.robot.half_track = half_track;
  }

  /// Raw counts with the acceleration first, or m/s^2 behind deg/s.
  void imu(std::uint64_t type, Fields& fields, Origin at, Assembler& to) {
    const bool raw = type != kMbotImu;
    const std::int64_t own = fields.int64();  // not a time in a type of raw counts: the event's own time serves
    at.stamp = raw ? onOneClock(at.received, 0) : onOneClock(own, delayOf(at.sensor));
    const auto vector = [&](double scale) {
      Eigen::Vector3d v;
      for (int i = 0; i < 3; ++i) {
        v[i] = type == kMaebotImu       ? fields.number<double>()
               : type == kMaebotSensors ? fields.number<std::int16_t>()
                                        : fields.real();
        v[i] = raw ? v[i] / scale : v[i];
      }
      return v;
    };
    const Eigen::Vector3d first = vector(kAccelCounts), second = vector(kGyroCounts);
    Eigen::Vector3d gyro = raw ? second : first, accel = raw ? first : second;
    for (int i = 0; i < 3; ++i) {
      gyro[i] = gyro[i] * std::numbers::pi / 180.0;
      if (raw) accel[i] *= kStandardGravity;
    }
    if (!fields.ok() || at.stamp <= 0 || !gyro.allFinite() || !accel.allFinite()) {
      return to.refuse(at, "an IMU reading that does not decode");
    }
    to.imu(at, gyro, accel);
  }

  /// Odometry where there are no encoders, or the truth. @return false: neither
  bool pose(Fields& fields, Origin at, Assembler& to) {
    const bool odometry = !has_encoders_ && (at.sensor == "ODOMETRY" || at.sensor == "MBOT_ODOMETRY");
    if (!odometry && !(truth_poses_ && at.sensor == truth_.channel)) return false;
    at.stamp = onOneClock(fields.int64(), delayOf(at.sensor));
    const double x = fields.real(), y = fields.real(), theta = fields.real();
    const bool decoded = fields.ok() && at.stamp > 0 && isFinite(Pose2{x, y, theta});
    if (odometry) {
      decoded ? to.wheels(at, {x, y, theta}) : to.refuse(at, "odometry that does not decode");
    } else if (decoded) {
      truth_poses_->write(at.stamp, {x, y, theta});
      ++to.recording.poses;
    } else {
      at.sensor.clear();
      to.refuse(at, "a pose that does not decode");
    }
    return true;
  }

  const MbotTruth& truth_;
  const MbotBase& base_;
  std::map<std::string, ReceiptDelay> delays_;  // of channels
  bool has_encoders_ = false;
  std::optional<TrajectoryWriter> truth_poses_;
  Pose2 pose_;  // by the encoders
  std::optional<std::array<std::int64_t, 2>> last_ticks_;
};

}  // namespace

bool isMbotLog(const std::filesystem::path& file) {
  EventLogReader log(file);
  for (LogEvent event; log.next(event);) {
    if (Fields(event.data).number<std::uint64_t>() == kMbotLidar) return true;
    if (event.channel == channel::kScan) return false;
  }
  return false;
}

Recording convertMbot(const std::filesystem::path& in, const std::filesystem::path& out, const MbotTruth& truth,
                      const MbotBase& base) {
  return assemble(Mbot(in, truth, base), out);
}

}  // namespace slam
