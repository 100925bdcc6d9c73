// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/can/can_link.hpp"

#include <algorithm>
#include <cerrno>
#include <linux/can/error.h>

namespace slam {
namespace {

using namespace std::chrono_literals;

constexpr Duration kFirstBackOff = 100ms, kLongestBackOff = 1s;
constexpr Duration kLook = 50ms;        // the socket tells when an interface goes down, not when it is up again
constexpr Duration kFrameTime = 300us;  // of 8 bytes at 500 kbit/s: the queue has room again after that

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
  open_ = false;
  dropWaiting();
  state_ = CanLinkState::kGone;
}

void CanLink::noteError(int error) {
  if (error == ENODEV || error == ENXIO || error == EBADF) {
    close();
    back_off_ = std::min(kFirstBackOff, longest_wait_);
  } else if (error == ENETDOWN) {
    dropWaiting();  // an old set-point must not be obeyed when the interface comes back
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
  const auto end = waiting_.begin() + static_cast<std::ptrdiff_t>(waiting_count_);
  const auto older = std::find_if(waiting_.begin(), end, [&](const can::Frame& f) { return f.id == frame.id; });
  const bool full = waiting_count_ == waiting_.size();
  if (older != end || full) {
    ++counters_.replaced;
    std::move((older != end ? older : waiting_.begin()) + 1, end, older != end ? older : waiting_.begin());
    --waiting_count_;
  }
  waiting_[waiting_count_++] = frame;
  flush(now);
  return waiting_count_ == 0 && usable();
}

void CanLink::flush(Timestamp now) {
  std::size_t done = 0;
  while (done < waiting_count_ && now >= next_send_ && usable()) {
    const int error = port_->send(waiting_[done]);
    if (error == 0) {
      ++counters_.sent;
      ++done;
      continue;
    }
    if (error == ENOBUFS || error == EAGAIN) ++counters_.queue_full;
    noteError(error);
    if (waiting_count_ == 0) return;  // the interface is down or gone, and took all with it
    next_send_ = now + kFrameTime;
    break;
  }
  std::move(waiting_.begin() + static_cast<std::ptrdiff_t>(done),
            waiting_.begin() + static_cast<std::ptrdiff_t>(waiting_count_), waiting_.begin());
  waiting_count_ -= done;
}

}  // namespace slam
