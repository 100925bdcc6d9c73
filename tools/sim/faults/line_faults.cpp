// SPDX-License-Identifier: BSD-3-Clause
#include "tools/sim/faults/line_faults.hpp"

#include <utility>

namespace slam::sim {

bool LineFaults::inject(std::string_view kind, double value) {
  using F = LineFaults;
  static constexpr FaultKind<F> kKinds[] = {
      {"unplug", &F::unplugged_},          // the port is gone; 0: it is back
      {"garbage", &F::garbage_},           // each byte on its way to the host is a random one
      {"delay", &F::delay_, 0.0, 2000.0},  // [ms] that each byte comes later
  };
  return injectFault(kKinds, *this, kind, value);
}

std::vector<std::uint8_t> LineFaults::pass(std::vector<std::uint8_t> bytes, Timestamp now) {
  if (garbage_) {
    for (std::uint8_t& byte : bytes) byte = static_cast<std::uint8_t>(random_());
  }
  if (delay_ == Duration(0) && delayed_.empty()) return bytes;
  if (!bytes.empty()) delayed_.push_back({now + delay_, std::move(bytes)});
  std::vector<std::uint8_t> arrived;
  for (; !delayed_.empty() && (delayed_.front().due <= now || delay_ == Duration(0)); delayed_.pop_front()) {
    arrived.insert(arrived.end(), delayed_.front().bytes.begin(), delayed_.front().bytes.end());
  }
  return arrived;
}

}  // namespace slam::sim
