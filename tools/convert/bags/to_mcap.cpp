// SPDX-License-Identifier: BSD-3-Clause
#include <array>
#include <nlohmann/json.hpp>
#include <optional>

#include "config/loader.hpp"
#include "tools/common/trajectory.hpp"
#include "tools/convert/bags/log_export.hpp"
#include "tools/convert/bags/mcap_writer.hpp"
#include "tools/convert/formats.hpp"
#include "tools/foxglove/foxglove_feed.hpp"

namespace slam {
namespace {

class McapExport : public LogExport<McapExport> {
 public:
  McapExport(const std::filesystem::path& out, const std::filesystem::path& trajectory) : writer_(out) {
    if (trajectory.empty()) return;
    trajectory_ = readTrajectory(trajectory);
    feed_.takePlacesFromOutside();
  }

  std::uint64_t written() const { return writer_.messages(); }
  void finish() {
    if (!placed_)
      recording_.notes.push_back("no pose in it: slam-replay --trajectory FILE makes one, --trajectory FILE takes it");
    writer_.close();
  }

 private:
  friend LogExport;

  void write(const config_t& message) {
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

  void write(const scan_t& message) {
    if (!feed_.take(message)) return rejectMeasurement(channel::kScan);
    recording_.use(recording_.sensor(channel::kScan), &Recording::scans, message.utime);
    if (trajectory_.empty()) return;
    if (const auto pose = poseAt(trajectory_, fromMicroseconds(message.utime))) {
      placed_ = true;
      feed_.place(message.utime, *pose);
    }
  }

  void write(const depth_t& message) {
    if (!feed_.take(message)) return rejectMeasurement(channel::kDepth);
    recording_.sensor(channel::kDepth).use(message.utime);
  }

  void write(const wheels_t& message) {
    recording_.use(recording_.sensor(channel::kWheels), &Recording::wheels, message.utime);
    feed_.take(message);
  }

  void write(const imu_t& message) {
    recording_.use(recording_.sensor(channel::kImu), &Recording::imu, message.utime);
    feed_.take(message);
  }

  void write(const pose_estimate_t& message) {
    placed_ = placed_ || trajectory_.empty();
    pass(channel::kSlamPose, message);
  }
  void write(const odometry_t& message) { pass(channel::kOdometry, message); }
  void write(const health_t& message) { pass(channel::kHealth, message); }
  void write(const problems_t& message) { pass(channel::kProblems, message); }
  void draw(const MapPicture::Picture& map, std::int64_t /*utime*/) { feed_.take(map); }

  template <typename Message>
  void pass(const char* channel, const Message& message) {
    recording_.sensor(channel).use(message.utime);
    feed_.take(message);
  }

  void send(FoxgloveTopic topic, std::int64_t utime, const nlohmann::json& message) {
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
  FoxgloveFeed feed_{
      [this](FoxgloveTopic topic, std::int64_t utime, const nlohmann::json& message) { send(topic, utime, message); }};
  bool placed_ = false;
};

}  // namespace

Recording convertToMcap(const std::filesystem::path& in, const std::filesystem::path& out,
                        const std::filesystem::path& trajectory) {
  return McapExport(out, trajectory).run(in);
}

}  // namespace slam
