// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <Eigen/Geometry>
#include <cstdint>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "core/scan.hpp"
#include "tools/convert/bags/ros_source.hpp"

/// The messages of ROS that slam-convert reads, of ROS 1 and of ROS 2 (CDR).
namespace slam::ros {

inline constexpr const char *kImu = "sensor_msgs/Imu", *kOdometry = "nav_msgs/Odometry",
                            *kJoints = "sensor_msgs/JointState";

struct Header {
  std::int64_t stamp = 0;  ///< [us]; 0: none
  std::string frame;       ///< without a slash before it
};

struct Scan {
  double range_min = 0.0;  ///< [m]
  double range_max = 0.0;  ///< [m]; 0: not told
  LaserScan scan;          ///< without stamp; of several echoes the first
  int thinned = 1;         ///< every so manieth beam, for so many fit into a scan
};

struct Imu {
  Eigen::Vector3d gyro, accel;  ///< [rad/s, m/s^2] accel is zero where not measured
};

struct Odometry {
  Eigen::Isometry3d T_odom_child;
};

struct Joints {
  std::vector<std::string> names;
  std::vector<double> positions;  ///< [rad]
};

struct Transform {
  Header header;  ///< of the parent
  std::string child_frame;
  Eigen::Isometry3d T_parent_child;
};

struct Message {
  Header header;            ///< of transforms: each has its own
  std::string child_frame;  ///< of odometry
  std::variant<Joints, Scan, Imu, Odometry, std::vector<Transform>> content;
};

bool isScan(const std::string& type);  ///< LaserScan or MultiEchoLaserScan
bool isTf(const std::string& type);    ///< transforms, of ROS 1 or 2
bool isRead(const std::string& type);  ///< any of those here

/// Why messages of this topic cannot be read: their definition is another than the one known here, or none; empty: they
/// can.
std::string refusal(const RosTopic& topic);

/// What a message of a type is called that does not decode.
std::string undecoded(const std::string& type);

/// @return nullopt for bytes that are not such a message to the last one
std::optional<Message> read(const RosMessage& message);

}  // namespace slam::ros
