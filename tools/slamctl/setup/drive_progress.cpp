// SPDX-License-Identifier: BSD-3-Clause
#include "tools/slamctl/setup/drive_progress.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "bus/channels.hpp"
#include "bus/event_log.hpp"
#include "bus/received.hpp"

namespace slam {
namespace {

constexpr double kStretch = 0.1;       // [m] or [rad]: shorter ones are the encoders' steps
constexpr double kJump = 1.0;          // [m] or [rad] since the sample before: the wheels' frame is another one
constexpr double kStraightTurn = 0.2;  // [rad/m] at most, straight on

}  // namespace

void DriveWatch::move(const Pose2& T_wheels_base) {
  if (T_wheels_begin_) {
    const Pose2 stretch = between(*T_wheels_begin_, T_wheels_base);
    const double way = stretch.translation().norm(), turn = stretch.theta;
    if (way < kStretch && std::abs(turn) < kStretch) return;
    if (way < kJump && std::abs(turn) < kJump) {
      driven_.way += way;
      if (std::abs(turn) <= kStraightTurn * way) driven_.straight += way;
      driven_.left += std::max(turn, 0.0);
      driven_.right += std::max(-turn, 0.0);
    }
  }
  T_wheels_begin_ = T_wheels_base;
}

void DriveWatch::look() {
  std::error_code error;
  if (std::filesystem::file_size(log_, error) <= read_ || error) return;
  try {
    EventLogReader reader(log_, read_);
    for (LogEvent event; reader.next(event);) {
      read_ += recordSize(event.channel, event.data);
      scans_ = scans_ || event.channel == channel::kScan;
      if (event.channel != channel::kWheels) continue;
      const Received<wheels_t> wheels(event.data);
      if (wheels.sample) move(wheels.sample->T_wheels_base);
    }
  } catch (const std::runtime_error&) {  // nothing whole is behind that yet
  }
}

}  // namespace slam
