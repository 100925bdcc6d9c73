// SPDX-License-Identifier: BSD-3-Clause
#include "tools/sim/lidar/turn_emulator.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <utility>

namespace slam::sim {
namespace {

constexpr std::size_t kLongestCommand = 256;  // [characters]; a longer one is none

}  // namespace

Duration TurnEmulator::Turn::untilLast() const {
  return fromSeconds(toSeconds(time) * (beams - 1) * std::abs(step) / (2.0 * std::numbers::pi));
}

TurnEmulator::TurnEmulator(Measure measure, const Turn& turn, char end)
    : measure_(std::move(measure)), turn_(turn), end_(end) {}

void TurnEmulator::receive(std::span<const std::uint8_t> bytes, Timestamp now, std::vector<std::uint8_t>& out) {
  beginFaults(now);
  if (faults_.silent || now < paused_until_) return;
  for (const std::uint8_t byte : bytes) {
    if (static_cast<char>(byte) != end_) {
      if (command_.size() < kLongestCommand) command_.push_back(static_cast<char>(byte));
      continue;
    }
    const std::string answer = answerTo(std::exchange(command_, {}));
    out.insert(out.end(), answer.begin(), answer.end());
  }
}

bool TurnEmulator::inject(std::string_view kind, double value) {
  constexpr std::array<std::string_view, 5> kRplidars = {"encoder_reset", "stale", "stuck", "unit", "other"};
  return std::find(kRplidars.begin(), kRplidars.end(), kind) == kRplidars.end() && faults_.inject(kind, value);
}

void TurnEmulator::beginFaults(Timestamp now) {
  constexpr Duration kBoot = std::chrono::milliseconds(1000);
  if (booted_ == Timestamp{}) booted_ = began_ = now;
  if (std::exchange(faults_.reboot, false)) {
    scanning_ = false;
    booted_ = paused_until_ = now + kBoot;
  }
  if (faults_.pause > Duration(0)) paused_until_ = now + std::exchange(faults_.pause, Duration(0));
  if (faults_.turn > Duration(0)) turn_.time = std::exchange(faults_.turn, Duration(0));
}

void TurnEmulator::stream(Timestamp now, std::vector<std::uint8_t>& out) {
  beginFaults(now);
  const Duration beam_time = turn_.untilLast() / std::max(1, turn_.beams - 1);
  for (; began_ + turn_.untilLast() <= now; began_ += turn_.time, ++number_) {
    if (!scanning_ || faults_.silent || faults_.stalled || began_ < paused_until_) continue;
    std::vector<double> ranges;
    for (int i = 0; i < turn_.beams; ++i) {
      const double bearing = std::remainder(turn_.first + i * turn_.step, 2.0 * std::numbers::pi);
      ranges.push_back(faults_.range_factor * faults_.nextFate().of(measure_(began_ + i * beam_time, bearing)));
    }
    const std::string text = encode(ranges, began_ - booted_, number_);
    std::vector<std::uint8_t> message(text.begin(), text.end());
    faults_.damage(message, true);
    out.insert(out.end(), message.begin(), message.end());
  }
}

}  // namespace slam::sim
