// SPDX-License-Identifier: BSD-3-Clause
#include <array>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <slam/odometry_t.hpp>
#include <stdexcept>

#include "bus/channels.hpp"
#include "bus/checked_decode.hpp"
#include "bus/event_log.hpp"
#include "bus/messages.hpp"
#include "config/loader.hpp"
#include "tools/common/trajectory.hpp"
#include "tools/convert/bags/mcap_writer.hpp"
#include "tools/convert/formats.hpp"
#include "tools/foxglove/foxglove_feed.hpp"

namespace slam {
namespace {

class Export {
 public:
  Export(const std::filesystem::path& out, const std::filesystem::path& trajectory) : writer_(out) {
    if (trajectory.empty()) return;
    trajectory_ = readTrajectory(trajectory);
    feed_.takePlacesFromOutside();
  }

  Recording run(const std::filesystem::path& in) {
    recording_.format = "slamd's log";
    EventLogReader reader(in);
    std::map<std::string, int> others;
    for (LogEvent event; reader.next(event);) {
      if (!add(event)) ++others[event.channel];
    }
    if (writer_.messages() == 0) throw std::runtime_error(in.string() + ": no message of slamd in it");
    for (const auto& [channel, count] : others)
      recording_.unused.push_back(channel + ", " + std::to_string(count) + " messages");
    if (!placed_)
      recording_.notes.push_back("no pose in it: slam-replay --trajectory FILE makes one, --trajectory FILE takes it");
    writer_.close();
    return recording_;
  }

 private:
  /// @return false: a channel that is not shown
  bool add(const LogEvent& event) {
    received_ = event.utime;
    const auto& name = event.channel;
    if (name == channel::kConfig) return take<config_t>(event);
    if (name == channel::kScan) return take<scan_t>(event);
    if (name == channel::kDepth) return take<depth_t>(event);
    if (name == channel::kWheels) return take<wheels_t>(event);
    if (name == channel::kImu) return take<imu_t>(event);
    if (name == channel::kSlamPose) return take<pose_estimate_t>(event);
    if (name == channel::kHealth) return take<health_t>(event);
    if (name == channel::kProblems) return take<problems_t>(event);
    if (name == channel::kMapMeta) return take<map_meta_t>(event);
    if (name == channel::kMapTile) return take<map_tile_t>(event);
    return name == channel::kOdometry && take<odometry_t>(event);
  }

  template <typename Message>
  bool take(const LogEvent& event) {
    const auto message = decodeChecked<Message>(event.data);
    if (!message) return refuse(event);
    show(*message);
    return true;
  }

  bool refuse(const LogEvent& event) {
    recording_.reject(recording_.sensor(event.channel), event.channel, "a message that does not decode");
    return true;
  }

  void show(const config_t& message) {
    try {
      const Config config = parseConfig(message.configuration, channel::kConfig);
      const Pose2& T_base_lidar = config.front_end.lidar.T_base_lidar;
      feed_.mount(config);
      recording_.robot.lidar_x = T_base_lidar.x;
      recording_.robot.lidar_y = T_base_lidar.y;
      recording_.robot.lidar_yaw = T_base_lidar.theta;
      recording_.robot.lidar_upside_down = config.front_end.lidar.upside_down;
      recording_.robot.mount_source = channel::kConfig;
    } catch (const ConfigError& error) {
      recording_.notes.push_back(std::string("where lidar and camera sit is not known: ") + error.what());
    }
  }

  void show(const scan_t& message) {
    if (!feed_.take(message))
      return recording_.reject(recording_.sensor(channel::kScan), channel::kScan, "no measurement");
    recording_.use(recording_.sensor(channel::kScan), &Recording::scans, message.utime);
    if (trajectory_.empty()) return;
    if (const auto pose = poseAt(trajectory_, fromMicroseconds(message.utime))) {
      placed_ = true;
      feed_.place(message.utime, *pose);
    }
  }

  void show(const depth_t& message) {
    if (!feed_.take(message))
      return recording_.reject(recording_.sensor(channel::kDepth), channel::kDepth, "no measurement");
    recording_.sensor(channel::kDepth).use(message.utime);
  }

  void show(const wheels_t& message) {
    recording_.use(recording_.sensor(channel::kWheels), &Recording::wheels, message.utime);
    feed_.take(message);
  }

  void show(const imu_t& message) {
    recording_.use(recording_.sensor(channel::kImu), &Recording::imu, message.utime);
    feed_.take(message);
  }

  void show(const pose_estimate_t& message) {
    placed_ = placed_ || trajectory_.empty();
    pass(channel::kSlamPose, message);
  }
  void show(const odometry_t& message) { pass(channel::kOdometry, message); }
  void show(const health_t& message) { pass(channel::kHealth, message); }
  void show(const problems_t& message) { pass(channel::kProblems, message); }
  void show(const map_meta_t& message) { drawMap(channel::kMapMeta, message); }
  void show(const map_tile_t& message) { drawMap(channel::kMapTile, message); }

  template <typename Message>
  void pass(const char* channel, const Message& message) {
    recording_.sensor(channel).use(message.utime);
    feed_.take(message);
  }

  template <typename Message>
  void drawMap(const char* channel, const Message& message) {
    recording_.sensor(channel).use(message.utime);
    map_.add(message);
    if (!map_.due(received_)) return;
    if (const auto picture = map_.draw(received_)) feed_.take(*picture);
  }

  void write(FoxgloveTopic topic, std::int64_t utime, const nlohmann::json& message) {
    auto& channel = channels_[static_cast<std::size_t>(topic)];
    if (!channel) {
      const FoxgloveChannel& of = foxgloveChannels()[static_cast<std::size_t>(topic)];
      channel = writer_.addChannel(of.topic, of.schema_name, of.schema);
    }
    writer_.write(*channel, received_, utime, message.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace));
  }

  McapWriter writer_;
  std::array<std::optional<std::uint16_t>, kFoxgloveTopics> channels_;  // by topic, of those that have messages
  Trajectory trajectory_;
  Recording recording_;
  FoxgloveFeed feed_{
      [this](FoxgloveTopic topic, std::int64_t utime, const nlohmann::json& message) { write(topic, utime, message); }};
  MapPicture map_;
  std::int64_t received_ = 0;  // [us]
  bool placed_ = false;
};

}  // namespace

Recording convertToMcap(const std::filesystem::path& in, const std::filesystem::path& out,
                        const std::filesystem::path& trajectory) {
  return Export(out, trajectory).run(in);
}

}  // namespace slam
