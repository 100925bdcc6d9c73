// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "core/counter_info.hpp"
#include "drivers/can/can_port.hpp"

namespace slam {

enum class CanLinkState : std::uint8_t {
  kGone,         ///< no such interface, or it was removed
  kUnsupported,  ///< the kernel has no CAN
  kRefused,      ///< the system refuses the socket for another reason
  kDown,
  kBusOff,
  kErrorPassive,  ///< on the bus, but with too many errors
  kUp,
};

struct CanLinkCounters {
  std::uint64_t received = 0, sent = 0;
  std::uint64_t queue_full = 0, send_errors = 0, replaced = 0, overflows = 0, bus_offs = 0, restarts = 0, opened = 0;

  template <typename Visitor>
  friend void visitCounters(const CanLinkCounters& c, Visitor&& visit) {
    visit(CounterInfo{"can.received", "frames", "Frames that were received."}, c.received);
    visit(CounterInfo{"can.sent", "frames", "Frames that the interface took."}, c.sent);
    visit(CounterInfo{"can.queue_full", "times", "The interface did not take a frame."}, c.queue_full);
    visit(CounterInfo{"can.send_errors", "times", "The interface refused a frame for another reason."}, c.send_errors);
    visit(CounterInfo{"can.replaced", "frames", "Waiting frames that a newer one of the same id put out."}, c.replaced);
    visit(CounterInfo{"can.overflows", "times", "The controller lost frames."}, c.overflows);
    visit(CounterInfo{"can.bus_offs", "times", "The controller went off the bus."}, c.bus_offs);
    visit(CounterInfo{"can.restarts", "times", "The controller was restarted after that."}, c.restarts);
    visit(CounterInfo{"can.opened", "times", "The interface was opened."}, c.opened);
  }
};

/// Keeps a CAN interface in use through all that happens to it: down and up, unplugged and plugged in again, bus-off
/// and restarted, a full queue, a socket that takes no frame any more. Never waits, never spins: at most one attempt of
/// each kind a tick.
class CanLink {
 public:
  /// @param ids 11-bit identifiers to receive
  /// @param longest_wait between attempts to open an interface that is not there
  CanLink(std::unique_ptr<CanPort> port, std::string interface, std::vector<std::uint32_t> ids,
          Duration longest_wait = std::chrono::seconds(1));

  /// Opens the interface if there is none, looks at its state, and sends what waits. Before the receive() calls.
  void tick(Timestamp now);
  /// The next data frame; error frames are digested on the way. @return false: no more for now
  bool receive(StampedCanFrame& out);
  /// Sends at once, or keeps the frame while the interface does not take it: one of each id, the newest.
  /// @return whether the interface has taken it, and all that waited
  bool send(const can::Frame& frame, Timestamp now);
  /// Forgets what waits to be sent.
  void dropWaiting() { waiting_.clear(); }
  void close();

  CanLinkState state() const { return state_; }
  bool usable() const { return state_ == CanLinkState::kUp || state_ == CanLinkState::kErrorPassive; }
  /// The interface is there, and has taken no frame for 75 ms although there were some.
  bool isBlocked() const { return blocked_ && usable(); }
  const CanLinkCounters& counters() const { return counters_; }

 private:
  /// Frames that wait for room, oldest first: one of each id, the newest.
  class Waiting {
   public:
    /// @return whether it puts another one out: the older one of its id, or the oldest where there is no room
    bool put(const can::Frame& frame);
    bool empty() const { return count_ == 0; }
    const can::Frame& front() const { return frames_[0]; }
    void pop() { erase(frames_.begin()); }
    void clear() { count_ = 0; }
    void holdUntil(Timestamp time) { next_ = time; }
    bool due(Timestamp now) const { return !empty() && now >= next_; }

   private:
    using Frames = std::array<can::Frame, 8>;
    Frames::iterator end() { return frames_.begin() + static_cast<std::ptrdiff_t>(count_); }
    void erase(Frames::iterator frame);

    Frames frames_{};
    std::size_t count_ = 0;
    Timestamp next_{};
  };
  void open(Timestamp now);
  void noteError(int error);
  void digest(const can::Frame& frame);
  void flush(Timestamp now);
  void noteSent(int error, Timestamp now);
  void reopenBlocked(Timestamp now);

  std::unique_ptr<CanPort> port_;
  std::string interface_;
  std::vector<std::uint32_t> ids_;
  Duration longest_wait_;
  CanLinkState state_ = CanLinkState::kGone;
  CanLinkCounters counters_;
  bool open_ = false;
  Timestamp next_open_{}, next_look_{};
  Timestamp taken_{};  // when a frame was taken last, or none was there to be sent
  Timestamp next_reopen_{};
  bool blocked_ = false;
  int send_error_ = 0;  // of the last frame
  Duration back_off_{0};
  Waiting waiting_;
};

/// How long something has been silent on a link, counted from when the link became usable at the earliest.
class LinkSilence {
 public:
  void look(bool usable, Timestamp now) {
    if (usable && !was_usable_) begin_ = now;
    was_usable_ = usable;
  }
  bool since(Timestamp event, Timestamp now, Duration limit) const { return now - std::max(event, begin_) > limit; }
  /// It has come since then.
  bool isFresh(Timestamp event) const { return event >= begin_ && event != Timestamp{}; }
  Timestamp begin() const { return begin_; }

 private:
  Timestamp begin_{};
  bool was_usable_ = false;
};

}  // namespace slam
