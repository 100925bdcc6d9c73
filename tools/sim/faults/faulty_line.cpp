// SPDX-License-Identifier: BSD-3-Clause
#include "tools/sim/faults/faulty_line.hpp"

#include <asm/termbits.h>  // termios2, for any baud rate; it excludes <termios.h>
#include <cmath>
#include <poll.h>
#include <sys/ioctl.h>
#include <utility>

namespace slam::sim {

void FaultyLine::plugIn() {
  if (tcp_port_ && !server_) {
    server_.emplace(*tcp_port_);
    tcp_port_ = server_->port();
  } else if (!tcp_port_ && !port_) {
    port_.emplace(link_);
  }
}

/// Whether whoever opened the port has set the device's rate.
bool FaultyLine::isUnderstood() const {
  struct termios2 mode {};
  if (baud_ == 0 || !port_ || ioctl(port_->descriptor(), TCGETS2, &mode) != 0) return true;
  return static_cast<int>(mode.c_ospeed) == baud_;
}

bool FaultyLine::inject(std::string_view kind, double value) {
  if (kind == "baud") {
    constexpr double kFastest = 4e6;  // [bit/s]
    if (!(value >= 0.0 && value <= kFastest) || value != std::floor(value)) return false;
    baud_ = static_cast<int>(value);
    return true;
  }
  if (!faults_.inject(kind, value)) return false;
  if (faults_.unplugged()) {
    port_.reset();
    server_.reset();
  } else {
    plugIn();
  }
  return true;
}

std::vector<std::uint8_t> FaultyLine::receive(Duration timeout) {
  using namespace std::chrono_literals;
  std::vector<std::uint8_t> bytes(256);
  if (!port_ && !server_) {
    ::poll(nullptr, 0, static_cast<int>(timeout / 1ms));
    return {};
  }
  bytes.resize(server_ ? server_->read(bytes, timeout) : port_->stream().read(bytes, timeout).size);
  if (!isUnderstood()) bytes.clear();
  return bytes;
}

void FaultyLine::send(std::vector<std::uint8_t> bytes, Timestamp now) {
  std::vector<std::uint8_t> arrived = faults_.pass(std::move(bytes), now);
  if (!isUnderstood()) {  // some of its bits make no byte, the others make any
    std::erase_if(arrived, [this](std::uint8_t) { return random_() % 2 == 0; });
    for (std::uint8_t& byte : arrived) byte = static_cast<std::uint8_t>(random_());
  }
  if (arrived.empty()) return;
  if (port_) port_->send(arrived);
  if (server_) server_->send(arrived);
}

}  // namespace slam::sim
