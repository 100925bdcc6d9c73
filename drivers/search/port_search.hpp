// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <atomic>
#include <cstdint>
#include <span>
#include <string>
#include <utility>

#include "drivers/lidar/search/lidar_search.hpp"

namespace slam {

/// What is on a port.
struct PortFinding {
  enum Kind : std::uint8_t { kNothing, kLidar, kBase, kImu, kForeign } kind = kNothing;
  std::string driver = {};    ///< word of lidar.driver, base.driver or imu.driver; empty: it has none
  std::string name = {};      ///< in words, with its article
  int baud = 0;               ///< [bit/s] at which it was understood
  bool is_usual_baud = true;  ///< the driver takes that one without being given it
  Problem problem = {};       ///< of kNothing: why
  bool is_open = true;        ///< the port could be opened
};

/// Finds out which lidar, base or IMU is on a port. It listens first, at each baud rate that devices send at unasked.
/// A port that stays silent is asked, in an order in which no question moves a motor or presses a button of any device
/// that slamd knows: a Create first, which would take a lidar's question for buttons, and whose interface is off
/// afterwards; then the HandsFree board, a VESC and an Xsens; then the lidars, as LidarSearch does; an Arduino for its
/// counters. Last, on a port from which nothing has come, it starts the lidars that wait for it (COIN-D4, LDS-01), and
/// stops them. It may wait and allocate, some 25 s for a port where nobody is; the port must be closed meanwhile.
class PortSearch {
 public:
  using Clock = LidarSearch::Clock;

  PortSearch(std::string path, PortOpener open, Clock now)
      : path_(std::move(path)), open_(std::move(open)), now_(now) {}

  PortFinding find(const std::atomic<bool>& cancel);

 private:
  struct Question;
  bool ask(const Question& question, const std::atomic<bool>& cancel);
  bool listen(std::span<const int> bauds, const std::atomic<bool>& cancel);
  bool take(const LidarFinding& lidar);
  bool take(const RecognisedDevice& sender);

  std::string path_;
  PortOpener open_;
  Clock now_;
  PortFinding found_;
};

}  // namespace slam
