// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <cstdint>
#include <span>
#include <string>

#include "core/timestamp.hpp"
#include "firmware_if/can_frame.hpp"

namespace slam {

struct StampedCanFrame {
  can::Frame frame;
  Timestamp stamp;  ///< when the kernel received it
};

/// The calls to the system that a CAN bus needs, so that what is made of them can be tested without CAN in the kernel.
/// Nothing waits. Errors are values of errno, 0 is none.
class CanPort {
 public:
  /// Of an id of open(): one of 29 bits.
  static constexpr std::uint32_t kExtended = 0x80000000U;
  virtual ~CanPort() = default;

  /// Opens and binds to an interface; closes what was open before. Frames with one of `ids` (11 bits, or 29 with
  /// kExtended; data, or remote with CAN_RTR_FLAG) are received, and error frames about the state of controller and
  /// bus.
  virtual int open(const std::string& interface, std::span<const std::uint32_t> ids) = 0;
  virtual void close() = 0;
  /// Takes the next frame. @return EAGAIN when there is none; frames that this port sent are not given back
  virtual int receive(StampedCanFrame& out) = 0;
  /// @return ENOBUFS when the interface's queue is full, ENETDOWN, ENXIO or ENODEV when it is down or gone
  virtual int send(const can::Frame& frame) = 0;
  /// Error that the system has noted since the last call.
  virtual int pendingError() = 0;
  /// Is the interface that open() bound to there and up? @return 0, ENETDOWN, ENODEV
  virtual int interfaceError() = 0;
};

}  // namespace slam
