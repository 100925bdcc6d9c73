// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/can/can_link.hpp"

#include <algorithm>
#include <cerrno>
#include <linux/can/error.h>
#include <utility>

namespace slam {
namespace {

using namespace std::chrono_literals;

constexpr Duration kFirstBackOff = 100ms, kLongestBackOff = 1s;
constexpr Duration kLook = 50ms;        // the socket tells when an interface goes down, not when it is up again
constexpr Duration kFrameTime = 300us;  // of 8 bytes at 500 kbit/s: the queue has room again after that
// 200 frames of the bus: no queue is busy for so long. With 20 ms to the first speed that is refused, and 100 ms to the
// next look of who tells it, it is told within 0.2 s.
constexpr Duration kBlocked = 75ms;
constexpr Duration kLinkReopen = 1s;  // between sockets of an interface that refuses frames

bool isLoss(int error) { return error == ENODEV || error == ENXIO || error == EBADF || error == ENETDOWN; }
bool isQueueFull(int error) { return error == ENOBUFS || error == EAGAIN; }

}  // namespace

CanLink::CanLink(std::unique_ptr<CanPort> port, std::string interface, std::vector<std::uint32_t> ids,
                 Duration longest_wait)
    : port_(std::move(port)), interface_(std::move(interface)), ids_(std::move(ids)), longest_wait_(longest_wait) {}

void CanLink::tick(Timestamp now) {
  if (!open_) {
    if (now >= next_open_) open(now);
    return;
  }
  noteError(port_->pendingError());
  if (open_ && now >= next_look_) {
    next_look_ = now + kLook;
    const int error = port_->interfaceError();
    if (error == 0 && state_ == CanLinkState::kDown) state_ = CanLinkState::kUp;
    noteError(error);
  }
  if (!open_) {
    next_open_ = now + back_off_;
    return;
  }
  flush(now);
  reopenBlocked(now);
}

void CanLink::open(Timestamp now) {
  const int error = port_->open(interface_, ids_);
  if (error != 0) {
    const bool gone = error == ENODEV || error == ENXIO;
    const bool unsupported = error == EAFNOSUPPORT || error == EPROTONOSUPPORT;
    state_ = gone ? CanLinkState::kGone : unsupported ? CanLinkState::kUnsupported : CanLinkState::kRefused;
    // The kernel looks for a module each time that it is asked for what it does not have, and that takes milliseconds.
    const Duration longest = unsupported ? kLongestBackOff : longest_wait_;
    back_off_ = std::clamp(2 * back_off_, std::min(kFirstBackOff, longest), longest);
    next_open_ = now + back_off_;
    return;
  }
  ++counters_.opened;
  open_ = true;
  back_off_ = 0ns;
  next_look_ = now + kLook;
  state_ = CanLinkState::kUp;
  noteError(port_->interfaceError());  // binding to an interface that is down succeeds
}

void CanLink::close() {
  port_->close();
  open_ = blocked_ = false;
  dropWaiting();
  state_ = CanLinkState::kGone;
}

void CanLink::noteError(int error) {
  if (error == ENODEV || error == ENXIO || error == EBADF) {
    close();
    back_off_ = std::min(kFirstBackOff, longest_wait_);
  } else if (error == ENETDOWN) {
    dropWaiting();  // an old set-point must not be obeyed when the interface comes back
    blocked_ = false;
    state_ = CanLinkState::kDown;
  }
}

bool CanLink::receive(StampedCanFrame& out) {
  while (open_) {
    const int error = port_->receive(out);
    if (error != 0) {
      noteError(error);
      return false;
    }
    if (out.frame.error) {
      digest(out.frame);
      continue;
    }
    ++counters_.received;
    if (state_ == CanLinkState::kBusOff) state_ = CanLinkState::kUp;  // frames and errors come in order
    return true;
  }
  return false;
}

void CanLink::digest(const can::Frame& frame) {
  const std::uint8_t controller = frame.data[1];
  if ((frame.id & CAN_ERR_CRTL) != 0) {
    if ((controller & (CAN_ERR_CRTL_RX_OVERFLOW | CAN_ERR_CRTL_TX_OVERFLOW)) != 0) ++counters_.overflows;
    if ((controller & (CAN_ERR_CRTL_RX_PASSIVE | CAN_ERR_CRTL_TX_PASSIVE)) != 0) state_ = CanLinkState::kErrorPassive;
    const bool recovered =
        (controller & (CAN_ERR_CRTL_ACTIVE | CAN_ERR_CRTL_RX_WARNING | CAN_ERR_CRTL_TX_WARNING)) != 0;
    if (recovered && state_ == CanLinkState::kErrorPassive) state_ = CanLinkState::kUp;
  }
  if ((frame.id & CAN_ERR_BUSOFF) != 0) {
    ++counters_.bus_offs;
    dropWaiting();
    state_ = CanLinkState::kBusOff;
  }
  if ((frame.id & CAN_ERR_RESTARTED) != 0) {
    ++counters_.restarts;
    state_ = CanLinkState::kUp;
  }
}

bool CanLink::send(const can::Frame& frame, Timestamp now) {
  if (!usable()) return false;
  counters_.replaced += waiting_.put(frame);
  flush(now);
  return waiting_.empty() && usable();
}

bool CanLink::Waiting::put(const can::Frame& frame) {
  const auto older = std::find_if(frames_.begin(), end(), [&](const can::Frame& f) { return f.id == frame.id; });
  const bool known = older != end(), replaces = known || count_ == frames_.size();
  if (replaces) erase(known ? older : frames_.begin());
  frames_[count_++] = frame;
  return replaces;
}

void CanLink::Waiting::erase(Frames::iterator frame) {
  std::move(frame + 1, end(), frame);
  --count_;
}

void CanLink::flush(Timestamp now) {
  if (waiting_.empty() && !blocked_) taken_ = now;
  while (waiting_.due(now) && usable()) {
    const int error = port_->send(waiting_.front());
    noteSent(error, now);
    if (error == 0) {
      waiting_.pop();
    } else if (!waiting_.empty()) {  // else the interface is down or gone, and took all with it
      waiting_.holdUntil(now + kFrameTime);
    }
  }
}

void CanLink::noteSent(int error, Timestamp now) {
  send_error_ = error;
  if (error == 0) {
    ++counters_.sent;
    taken_ = now;
    blocked_ = false;
    return;
  }
  ++(isQueueFull(error) ? counters_.queue_full : counters_.send_errors);
  // A socket can call an interface lost that is there and up: then it takes no frames, and that is all.
  if (!isLoss(error) || port_->interfaceError() != 0) noteError(error);
  if (usable() && now - taken_ >= kBlocked && !std::exchange(blocked_, true)) next_reopen_ = now;
}

/// A new socket helps where the old one is at fault; a queue that stays full is the interface's, and outlives it.
void CanLink::reopenBlocked(Timestamp now) {
  if (!blocked_ || !open_ || isQueueFull(send_error_) || now < next_reopen_) return;
  next_reopen_ = now + kLinkReopen;
  const bool passive = state_ == CanLinkState::kErrorPassive;
  open_ = false;
  open(now);
  if (usable() && passive) state_ = CanLinkState::kErrorPassive;  // the controller's, not the socket's
}

}  // namespace slam
