// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <memory>
#include <string>

#include "core/pose2.hpp"

namespace slam {

/// A message of ROS 2 as CDR: little-endian, each number at a multiple of its own size.
class CdrMessage {
 public:
  template <typename T>
  CdrMessage& put(T value) {
    bytes_.append((sizeof(T) - (bytes_.size() - kPrefix) % sizeof(T)) % sizeof(T), '\0');
    char raw[sizeof(T)];
    std::memcpy(raw, &value, sizeof(T));  // both ends are little-endian
    bytes_.append(raw, sizeof(T));
    return *this;
  }
  CdrMessage& text(const std::string& value) {
    put(static_cast<std::uint32_t>(value.size() + 1));
    bytes_ += value;
    bytes_ += '\0';
    return *this;
  }
  template <typename List>
  CdrMessage& list(const List& values) {
    put(static_cast<std::uint32_t>(values.size()));
    for (const auto& value : values) put(value);
    return *this;
  }
  CdrMessage& zeros(int count) {
    for (int i = 0; i < count; ++i) put(0.0);
    return *this;
  }
  /// std_msgs/Header. @param utime [us since the epoch]
  CdrMessage& header(std::int64_t utime, const std::string& frame) { return time(utime).text(frame); }
  CdrMessage& time(std::int64_t utime);
  /// geometry_msgs/Pose or Transform
  CdrMessage& pose(const Pose2& pose);
  /// The 6 x 6 covariance of a pose in the plane. @param covariance of (x, y, theta), row by row
  CdrMessage& covariance(const double (&covariance)[9]);
  const std::string& bytes() const { return bytes_; }

 private:
  static constexpr std::size_t kPrefix = 4;
  std::string bytes_ = std::string("\0\1\0\0", kPrefix);
};

/// A bag of ROS 2 that is written message by message.
class Ros2Bag {
 public:
  virtual ~Ros2Bag() = default;
  /// @param type package/msg/Type of rosDefinition() @param received [us since the epoch]
  /// @param utime [us since the epoch] of the message itself
  /// @throws std::runtime_error with file and reason where the disk does not take it
  virtual void write(const std::string& topic, const std::string& type, std::int64_t received, std::int64_t utime,
                     const std::string& message) = 0;
  /// @throws as write()
  virtual void close() = 0;
};

/// SQLite as rosbag2 writes it, or MCAP, by the name's end. What is there is replaced.
/// @throws std::runtime_error with file and reason, also for another end
std::unique_ptr<Ros2Bag> makeRos2Bag(const std::filesystem::path& file);

/// The text that describes a type with the types in it.
std::string rosDefinition(const std::string& type);

}  // namespace slam
