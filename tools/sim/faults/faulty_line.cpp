// SPDX-License-Identifier: BSD-3-Clause
#include "tools/sim/faults/faulty_line.hpp"

#include <poll.h>
#include <utility>

namespace slam::sim {

bool FaultyLine::inject(std::string_view kind, double value) {
  if (!faults_.inject(kind, value)) return false;
  if (faults_.unplugged()) {
    port_.reset();
  } else if (!port_) {
    port_.emplace(link_);
  }
  return true;
}

std::vector<std::uint8_t> FaultyLine::receive(Duration timeout) {
  using namespace std::chrono_literals;
  std::vector<std::uint8_t> bytes(256);
  if (!port_) {
    ::poll(nullptr, 0, static_cast<int>(timeout / 1ms));
    return {};
  }
  bytes.resize(port_->stream().read(bytes, timeout).size);
  return bytes;
}

void FaultyLine::send(std::vector<std::uint8_t> bytes, Timestamp now) {
  const std::vector<std::uint8_t> arrived = faults_.pass(std::move(bytes), now);
  if (port_ && !arrived.empty()) port_->send(arrived);
}

}  // namespace slam::sim
