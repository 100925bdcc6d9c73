// SPDX-License-Identifier: BSD-3-Clause
#include "tools/sim/faults/line_faults.hpp"

#include <utility>

namespace slam::sim {
namespace {

constexpr double kLongestDelay = 2000.0;  // [ms]

}  // namespace

bool LineFaults::inject(std::string_view kind, double value) {
  const bool flag = value == 0.0 || value == 1.0;
  if (kind == "unplug" && flag) return unplugged_ = value != 0.0, true;
  if (kind == "garbage" && flag) return garbage_ = value != 0.0, true;
  if (kind == "delay" && value >= 0.0 && value <= kLongestDelay) return delay_ = fromSeconds(1e-3 * value), true;
  return false;
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
