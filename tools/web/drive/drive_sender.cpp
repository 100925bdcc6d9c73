// SPDX-License-Identifier: BSD-3-Clause
#include "tools/web/drive/drive_sender.hpp"

#include <cstdint>
#include <slam/drive_t.hpp>
#include <vector>

#include "bus/channels.hpp"
#include "runtime/clock.hpp"

namespace slam {

bool publishDrive(LcmLink& link, const Twist2& twist, Timestamp now) {
  drive_t message{};
  message.utime = toMicroseconds(now + wallClockOffset());
  message.vx = twist.vx, message.vy = twist.vy, message.omega = twist.omega;
  std::vector<std::uint8_t> bytes(static_cast<std::size_t>(message.getEncodedSize()));
  message.encode(bytes.data(), 0, static_cast<int>(bytes.size()));
  return link.publish(channel::kDrive, bytes, now);
}

}  // namespace slam
