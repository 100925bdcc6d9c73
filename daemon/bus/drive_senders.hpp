// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <array>
#include <cstdint>
#include <string>

#include "bus/sender_clock.hpp"
#include "core/timestamp.hpp"
#include "problems/daemon.hpp"

namespace slam {

/// Whose speeds are driven where several programs send some.
enum class DriveOrder : std::uint8_t {
  kFirst,  ///< of who began first, until that one ends
  kLast    ///< of who began last; who was driven before goes on behind that one's end
};

/// Chooses among the programs that send SLAM_DRIVE the one that is driven. A program drives while it sends speeds, and
/// has ended with a zero or half a second without one. A zero of any program stops the base at once, and all others
/// that drive: they are not driven any more until each has ended, so that nothing moves the base on by itself.
class DriveSenders {
 public:
  using Sender = std::uint64_t;  ///< IPv4 address, port: of each program another

  explicit DriveSenders(DriveOrder order) : order_(order) {}

  /// A speed has come. @return whether it is driven
  bool take(Sender from, bool zero, Timestamp now);
  /// What the clock of a program is ahead or behind.
  SenderClocks& clock(Sender from, Timestamp now) { return entryOf(from, now).clock; }
  /// Our own clock was set: see SenderClocks::begin().
  void beginClocks(Duration ahead);
  /// While there are several; none: there is at most one.
  Problem problem(Timestamp now) const;

 private:
  struct Entry {
    Sender sender = 0;
    Timestamp received{};  // its last message
    Timestamp drove{};     // its last speed that was none of zero
    Timestamp began{};     // to drive; Timestamp{}: it does not
    bool stopped = false;  // by another one's zero, since it began
    SenderClocks clock = {};
  };
  static constexpr std::size_t kMost = 8;                             // the one that was silent longest goes
  static constexpr Duration kEnded = std::chrono::milliseconds(500);  // as a speed lasts
  static constexpr Duration kReported = std::chrono::seconds(2);      // after the last message

  Entry& entryOf(Sender sender, Timestamp now);
  bool drives(const Entry& entry, Timestamp now) const {
    return entry.began != Timestamp{} && !entry.stopped && now - entry.drove <= kEnded;
  }
  const Entry* followed(Timestamp now) const;

  DriveOrder order_;
  Duration ahead_{0};  // of our stamps, when the clocks began
  std::array<Entry, kMost> entries_{};
};

}  // namespace slam
