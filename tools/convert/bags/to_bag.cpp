// SPDX-License-Identifier: BSD-3-Clause
// Frames are those of REP 105, and of most robots: map, odom, base_link, laser.
#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <optional>
#include <slam/odometry_t.hpp>
#include <stdexcept>
#include <string>
#include <vector>

#include "bus/channels.hpp"
#include "bus/checked_decode.hpp"
#include "bus/event_log.hpp"
#include "bus/messages.hpp"
#include "config/loader.hpp"
#include "tools/convert/bags/ros2_bag.hpp"
#include "tools/convert/formats.hpp"
#include "tools/foxglove/map_picture.hpp"

namespace slam {
namespace {

constexpr const char *kMap = "map", *kOdom = "odom", *kBase = "base_link", *kLaser = "laser";

/// Bearings of a scan as LaserScan has them: from the first one in even steps.
struct EvenScan {
  float first = 0.0F, step = 0.0F, time_step = 0.0F;  // [rad, rad, s]
  std::vector<float> ranges, intensities;             // [m], device units
};

EvenScan evenScan(const LaserScan& scan, std::int64_t utime) {
  const auto beams = scan.beams();
  EvenScan even;
  const auto count = static_cast<float>(std::max(1, scan.size - 1));
  std::vector<double> turned{0.0};  // [rad] from the first beam, in acquisition order
  for (std::size_t i = 1; i < beams.size(); ++i)
    turned.push_back(turned.back() + wrapAngle(beams[i].bearing - beams[i - 1].bearing));
  even.first = beams.front().bearing;
  even.step = static_cast<float>(turned.back()) / count;
  even.time_step = (beams.back().time_offset - beams.front().time_offset) / count;
  const auto add = [&](float range, float intensity) {
    even.ranges.push_back(range > 0.0F ? range : std::numeric_limits<float>::infinity());  // REP 117
    even.intensities.push_back(intensity);
  };
  const bool one_way = std::is_sorted(turned.begin(), turned.end()) || std::is_sorted(turned.rbegin(), turned.rend());
  if (one_way) {  // each even bearing has the beam nearest to it, and so its time but for a fraction of a step
    std::size_t nearest = 0;
    for (std::size_t i = 0; i < beams.size(); ++i) {
      const double bearing = even.step * static_cast<double>(i);
      while (nearest + 1 < beams.size() &&
             std::abs(turned[nearest + 1] - bearing) <= std::abs(turned[nearest] - bearing))
        ++nearest;
      add(beams[nearest].range, beams[nearest].intensity);
    }
    return even;
  }
  const auto message = toLaserMessage(scan, utime, scan.size);
  even.first = message.rad0;
  even.step = message.radstep;
  even.time_step = 0.0F;  // the order of the beams is another
  for (const float range : message.ranges) add(range, 0.0F);
  return even;
}

class BagExport {
 public:
  explicit BagExport(const std::filesystem::path& out) : bag_(makeRos2Bag(out)) {}

  Recording run(const std::filesystem::path& in) {
    recording_.format = "slamd's log";
    EventLogReader reader(in);
    std::map<std::string, int> others;
    for (LogEvent event; reader.next(event);) {
      if (!add(event)) ++others[event.channel];
    }
    if (messages_ == 0) throw std::runtime_error(in.string() + ": no message of slamd in it");
    for (const auto& [channel, count] : others)
      recording_.unused.push_back(channel + ", " + std::to_string(count) + " messages");
    if (!mounted_)
      recording_.notes.push_back("no SLAM_CONFIG in it: where the lidar sits is not in the bag (base_link to laser)");
    bag_->close();
    return recording_;
  }

 private:
  /// @return false: a channel that is not written
  bool add(const LogEvent& event) {
    received_ = event.utime;
    const auto& name = event.channel;
    if (name == channel::kConfig) return take<config_t>(event);
    if (name == channel::kScan) return take<scan_t>(event);
    if (name == channel::kWheels) return take<wheels_t>(event);
    if (name == channel::kImu) return take<imu_t>(event);
    if (name == channel::kSlamPose) return take<pose_estimate_t>(event);
    if (name == channel::kMapMeta) return take<map_meta_t>(event);
    if (name == channel::kMapTile) return take<map_tile_t>(event);
    if (name != channel::kOdometry) return false;
    odometry_t message;  // of one size: its decoder reads no lengths
    if (message.decode(event.data.data(), 0, static_cast<int>(event.data.size())) < 0) return refuse(event, kUndecoded);
    write(message);
    return true;
  }

  template <typename Message>
  bool take(const LogEvent& event) {
    const auto message = decodeChecked<Message>(event.data);
    if (!message) return refuse(event, kUndecoded);
    write(*message);
    return true;
  }

  bool refuse(const LogEvent& event, const char* why) {
    recording_.reject(recording_.sensor(event.channel), event.channel, why);
    return true;
  }

  void send(const char* topic, const char* type, std::int64_t utime, const CdrMessage& message) {
    bag_->write(topic, type, received_, utime, message.bytes());
    ++messages_;
  }

  void transform(const char* topic, std::int64_t utime, const char* parent, const char* child, const Pose2& pose) {
    CdrMessage message;
    message.put(std::uint32_t{1}).header(utime, parent).text(child).pose(pose);
    send(topic, "tf2_msgs/msg/TFMessage", utime, message);
  }

  void write(const config_t& message) {
    if (mounted_) return;
    try {
      const auto& lidar = parseConfig(message.configuration, channel::kConfig).front_end.lidar;
      // Upside down the lidar is turned about its x axis by half a turn: (cos, sin) of half the yaw become x and y.
      const Pose2& T = lidar.T_base_lidar;
      CdrMessage mount;
      mount.put(std::uint32_t{1}).header(message.utime, kBase).text(kLaser).put(T.x).put(T.y).put(0.0);
      const double c = std::cos(0.5 * T.theta), s = std::sin(0.5 * T.theta);
      for (const double q : {lidar.upside_down ? c : 0.0, lidar.upside_down ? s : 0.0, lidar.upside_down ? 0.0 : s,
                             lidar.upside_down ? 0.0 : c})
        mount.put(q);
      send("/tf_static", "tf2_msgs/msg/TFMessage", message.utime, mount);
      mounted_ = true;
    } catch (const ConfigError& error) {
      recording_.notes.push_back(std::string("where the lidar sits is not known: ") + error.what());
    }
  }

  void write(const scan_t& message) {
    const auto scan = fromMessage(message);
    if (!scan || scan->size == 0)
      return recording_.reject(recording_.sensor(channel::kScan), channel::kScan, "no measurement");
    recording_.use(recording_.sensor(channel::kScan), &Recording::scans, message.utime);
    const EvenScan even = evenScan(*scan, message.utime);
    const auto last = static_cast<float>(even.ranges.size() - 1);
    CdrMessage out;
    out.header(message.utime, kLaser).put(even.first).put(even.first + last * even.step).put(even.step);
    out.put(even.time_step).put(last * even.time_step).put(message.range_min).put(message.range_max);
    send("/scan", "sensor_msgs/msg/LaserScan", message.utime, out.list(even.ranges).list(even.intensities));
  }

  void write(const wheels_t& message) {
    if (!fromMessage(message))
      return recording_.reject(recording_.sensor(channel::kWheels), channel::kWheels, "no measurement");
    recording_.use(recording_.sensor(channel::kWheels), &Recording::wheels, message.utime);
    CdrMessage odometry;
    odometry.header(message.utime, kOdom).text(kBase).pose({message.x, message.y, message.theta});
    odometry.zeros(36 + 6 + 36);
    send("/odom", "nav_msgs/msg/Odometry", message.utime, odometry);
    if (message.nwheels == 0) return;
    CdrMessage joints;
    joints.header(message.utime, "").put(static_cast<std::uint32_t>(message.nwheels));
    for (int i = 0; i < message.nwheels; ++i)
      joints.text(message.nwheels == 2 ? (i == 0 ? "wheel_left_joint" : "wheel_right_joint")
                                       : "wheel_" + std::to_string(i + 1) + "_joint");
    joints.list(message.angles).put(std::uint32_t{0}).put(std::uint32_t{0});
    send("/joint_states", "sensor_msgs/msg/JointState", message.utime, joints);
  }

  void write(const imu_t& message) {
    if (!fromMessage(message))
      return recording_.reject(recording_.sensor(channel::kImu), channel::kImu, "no measurement");
    recording_.use(recording_.sensor(channel::kImu), &Recording::imu, message.utime);
    CdrMessage out;
    out.header(message.utime, kBase).zeros(3).put(1.0).put(-1.0).zeros(8);  // -1: no orientation
    for (const double value : message.gyro) out.put(value);
    out.zeros(9);
    for (const double value : message.accel) out.put(value);
    send("/imu", "sensor_msgs/msg/Imu", message.utime, out.zeros(9));
  }

  void write(const pose_estimate_t& message) {
    recording_.sensor(channel::kSlamPose).use(message.utime);
    CdrMessage out;
    out.header(message.utime, kMap).pose({message.x, message.y, message.theta}).covariance(message.covariance);
    send("/pose", "geometry_msgs/msg/PoseWithCovarianceStamped", message.utime, out);
  }

  void write(const odometry_t& message) {
    recording_.sensor(channel::kOdometry).use(message.utime);
    const Pose2 T_odom_base{message.x, message.y, message.theta};
    CdrMessage out;
    out.header(message.utime, kOdom).text(kBase).pose(T_odom_base).covariance(message.covariance);
    out.put(message.twist[0]).put(message.twist[1]).zeros(3).put(message.twist[2]).zeros(36);
    send("/odometry/filtered", "nav_msgs/msg/Odometry", message.utime, out);
    transform("/tf", message.utime, kOdom, kBase, T_odom_base);
    transform("/tf", message.utime, kMap, kOdom, {message.map_odom[0], message.map_odom[1], message.map_odom[2]});
  }

  void write(const map_meta_t& message) { drawMap(channel::kMapMeta, message); }
  void write(const map_tile_t& message) { drawMap(channel::kMapTile, message); }

  template <typename Message>
  void drawMap(const char* channel, const Message& message) {
    recording_.sensor(channel).use(message.utime);
    map_.add(message);
    if (!map_.due(received_)) return;
    const auto map = map_.draw(received_);
    if (!map) return;
    CdrMessage out;
    out.header(map->utime, kMap).time(map->utime).put(static_cast<float>(map->resolution));
    out.put(static_cast<std::uint32_t>(map->columns)).put(static_cast<std::uint32_t>(map->rows)).pose(map->corner);
    send("/map", "nav_msgs/msg/OccupancyGrid", map->utime, out.list(map->cells));  // 255 unknown is -1 of int8
  }

  static constexpr const char* kUndecoded = "a message that does not decode";
  std::unique_ptr<Ros2Bag> bag_;
  Recording recording_;
  MapPicture map_;
  std::int64_t received_ = 0;  // [us]
  std::uint64_t messages_ = 0;
  bool mounted_ = false;
};

}  // namespace

Recording convertToBag(const std::filesystem::path& in, const std::filesystem::path& out) {
  return BagExport(out).run(in);
}

}  // namespace slam
