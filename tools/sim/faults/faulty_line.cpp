// SPDX-License-Identifier: BSD-3-Clause
#include "tools/sim/faults/faulty_line.hpp"

#include <poll.h>
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

bool FaultyLine::inject(std::string_view kind, double value) {
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
  return bytes;
}

void FaultyLine::send(std::vector<std::uint8_t> bytes, Timestamp now) {
  const std::vector<std::uint8_t> arrived = faults_.pass(std::move(bytes), now);
  if (arrived.empty()) return;
  if (port_) port_->send(arrived);
  if (server_) server_->send(arrived);
}

}  // namespace slam::sim
