// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <span>
#include <string>
#include <string_view>

#include "core/scan.hpp"
#include "drivers/byte_stream.hpp"
#include "drivers/device_status.hpp"
#include "drivers/lidar/codec/lidar_packets.hpp"
#include "drivers/lidar/rplidar_dialogue.hpp"
#include "drivers/line_device.hpp"

namespace slam {

/// What is said to a lidar that listens; most only send.
struct LidarTalk {
  struct Answer {
    std::string identity{};  ///< empty: it has not answered, which many do not
    Problem problem{};       ///< that it reports
    bool fault = false;      ///< and does not work for
  };
  Answer (*start)(rplidar::Dialogue&) = nullptr;  ///< asks who it is, and begins the scan; nullptr: nothing is asked
  void (*stop)(ByteStream&) = nullptr;
};

/// A lidar that sends packets, as a row of the table.
struct LidarFacts {
  const char* driver;      ///< word of lidar.driver
  const char* name;        ///< in words
  LineDevice line_device;  ///< as others on the port know it
  const LidarPackets* packets;
  int baud;                   ///< [bit/s]
  double sample_rate;         ///< [1/s]
  RangeLimits range;          ///< [m]
  bool clockwise = true;      ///< its angles rise clockwise, seen from above
  bool motor_by_dtr = false;  ///< DTR set: the motor turns
  LidarTalk talk{};
};

std::span<const LidarFacts> lidarTable();
/// @return nullptr for a driver without a row
const LidarFacts* findLidar(std::string_view driver);

}  // namespace slam
