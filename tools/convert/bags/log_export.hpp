// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <cstdint>
#include <filesystem>
#include <map>
#include <stdexcept>
#include <string>

#include "bus/channels.hpp"
#include "bus/checked_decode.hpp"
#include "bus/event_log.hpp"
#include "bus/messages.hpp"
#include "tools/convert/recording.hpp"
#include "tools/foxglove/map_picture.hpp"

namespace slam {

/// What a log of slamd becomes in another container. `Format` has a write() for each message that it shows, a draw()
/// for the map, written() for how many messages it has so far, and finish() for the end.
template <typename Format>
class LogExport {
 public:
  /// @throws std::runtime_error where nothing of the log can be shown
  Recording run(const std::filesystem::path& in) {
    recording_.format = "slamd's log";
    EventLogReader reader(in);
    std::map<std::string, int> others;
    for (LogEvent event; reader.next(event);) {
      if (!add(event)) ++others[event.channel];
    }
    if (format().written() == 0) throw std::runtime_error(in.string() + ": no message of slamd in it");
    for (const auto& [channel, count] : others)
      recording_.unused.push_back(channel + ", " + std::to_string(count) + " messages");
    format().finish();
    return recording_;
  }

 protected:
  void rejectMeasurement(const char* channel) {
    recording_.reject(recording_.sensor(channel), channel, "no measurement");
  }

  Recording recording_;
  std::int64_t received_ = 0;  // [us] the present message

 private:
  Format& format() { return static_cast<Format&>(*this); }

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
    constexpr bool kOfMap = std::is_same_v<Message, map_meta_t> || std::is_same_v<Message, map_tile_t>;
    if constexpr (kOfMap || requires(const Message& message) { format().write(message); }) {
      const auto message = decodeChecked<Message>(event.data);
      if (!message) return refuse(event);
      if constexpr (kOfMap) {
        drawMap(event.channel, *message);
      } else {
        format().write(*message);
      }
      return true;
    }
    return false;
  }

  bool refuse(const LogEvent& event) {
    recording_.reject(recording_.sensor(event.channel), event.channel, "a message that does not decode");
    return true;
  }

  template <typename Message>
  void drawMap(const std::string& channel, const Message& message) {
    recording_.sensor(channel).use(message.utime);
    map_.add(message);
    if (!map_.due(received_)) return;
    if (const auto picture = map_.draw(received_)) format().draw(*picture, message.utime);
  }

  MapPicture map_;
};

}  // namespace slam
