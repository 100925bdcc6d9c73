// SPDX-License-Identifier: BSD-3-Clause
#include "tools/sim/lidar/packet_emulator.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <stdexcept>
#include <string>
#include <utility>

#include "drivers/lidar/search/lidar_search.hpp"

namespace slam::sim {
namespace {

const LidarFacts& factsOf(std::string_view driver) {
  const LidarFacts* facts = findLidar(driver);
  if (facts == nullptr || findPacketFormat(driver) == nullptr)
    throw std::invalid_argument("no lidar " + std::string(driver) + " is simulated");
  return *facts;
}

/// Number that a YDLIDAR answers with; 0: it does not say who it is.
std::uint8_t modelOf(const LidarFacts& facts) {
  std::uint8_t model = 0xFF;
  while (model > 0 && ydlidarOf(model) != &facts) --model;
  return model;
}

double wrapDegrees(double angle) { return angle - 360.0 * std::floor(angle / 360.0); }

}  // namespace

PacketEmulator::PacketEmulator(Measure measure, std::string_view driver)
    : measure_(std::move(measure)),
      facts_(factsOf(driver)),
      format_(*findPacketFormat(driver)),
      sample_time_(fromSeconds(1.0 / facts_.sample_rate)),
      byte_time_(fromSeconds(10.0 / facts_.baud)),
      scanning_(facts_.talk.start == nullptr) {}

void PacketEmulator::receive(std::span<const std::uint8_t> bytes, Timestamp, std::vector<std::uint8_t>& out) {
  if (faults_.silent || facts_.talk.start == nullptr) return;
  const auto answer = [&](std::uint8_t type, std::vector<std::uint8_t> data) {
    const auto size = static_cast<std::uint8_t>(data.size());
    out.insert(out.end(), {0xA5, 0x5A, size, 0x00, 0x00, static_cast<std::uint8_t>(type > 0x7F ? 0x40 : 0x00), type});
    if (type <= 0x7F) out.insert(out.end(), data.begin(), data.end());
  };
  const std::uint8_t model = modelOf(facts_);
  for (const std::uint8_t byte : bytes) {
    heard_.push_back(byte);
    if (heard_.size() > 2) heard_.erase(heard_.begin());
    // The last two bytes of a command are enough to know it.
    const std::uint8_t before = heard_.size() < 2 ? 0 : heard_[0];
    const bool yd = before == 0xA5;
    if ((yd && byte == 0x60) || (before == 0xF0 && byte == 0x0F) || byte == 'b') scanning_ = true;
    if ((yd && (byte == 0x00 || byte == 0x65)) || (before == 0xF5 && byte == 0x0A) || byte == 'e') scanning_ = false;
    if (yd && byte == 0x60) answer(0x81, std::vector<std::uint8_t>(5));
    if (yd && byte == 0x90 && model != 0)
      answer(0x04, {model, 2, 1, 1, 2, 0, 2, 0, 0, 6, 0, 1, 0, 0, 0, 0, 0, 2, 0, 1});
    if (yd && byte == 0x92 && model != 0) answer(0x06, {static_cast<std::uint8_t>(std::min(faults_.health, 2)), 0, 0});
    if (!scanning_) line_.clear();
  }
}

bool PacketEmulator::inject(std::string_view kind, double value) {
  constexpr std::array<std::string_view, 5> kRplidars = {"encoder_reset", "stale", "stuck", "unit", "other"};
  return std::find(kRplidars.begin(), kRplidars.end(), kind) == kRplidars.end() && faults_.inject(kind, value);
}

void PacketEmulator::beginFaults(Timestamp now) {
  constexpr Duration kBoot = std::chrono::milliseconds(1000);
  if (started_ == Timestamp{}) started_ = next_ = now;
  if (std::exchange(faults_.reboot, false)) {
    paused_until_ = now + kBoot;
    started_ = now;
    uptime_ = Duration(0);
    scanning_ = facts_.talk.start == nullptr;
  }
  if (faults_.pause > Duration(0)) paused_until_ = now + std::exchange(faults_.pause, Duration(0));
  if (format_.fixed) sample_time_ = fromSeconds(1.0 / (360.0 * turnRate()));
}

/// Range along the beam that the unit reports at `angle` [deg].
double PacketEmulator::look(Timestamp stamp, double angle) {
  constexpr int kSteps = 3;  // of the search for the distance that a triangulating unit's shift depends on
  const LidarFaults::Fate fate = faults_.nextFate();
  const double sense = facts_.clockwise ? -1.0 : 1.0;
  double shift = 0.0, range = 0.0;
  for (int i = 0; i <= (format_.shift != nullptr ? kSteps : 0); ++i) {
    range = fate.of(measure_(stamp, sense * (angle + shift) * std::numbers::pi / 180.0));
    if (format_.shift != nullptr && range > 0.0) shift = format_.shift(1000.0 * range);
  }
  return faults_.range_factor * range;
}

std::vector<std::uint8_t> PacketEmulator::nextPacket() {
  PacketContents contents{.turn_rate = turnRate(), .uptime = uptime_ + (next_ - started_)};
  for (int i = 0; i < format_.samples; ++i, next_ += sample_time_) {
    contents.angles.push_back(angle_);
    contents.ranges.push_back(look(next_, angle_));
    angle_ =
        wrapDegrees(format_.fixed ? std::round(angle_ + 1.0) : angle_ + 360.0 * turnRate() * toSeconds(sample_time_));
  }
  std::vector<std::uint8_t> packet = format_.encode(contents);
  faults_.damage(packet, true);
  return packet;
}

void PacketEmulator::stream(Timestamp now, std::vector<std::uint8_t>& out) {
  beginFaults(now);
  if (faults_.silent || faults_.stalled || !scanning_ || now < paused_until_) {
    line_.clear();
    next_ = now;
    return;
  }
  // A packet leaves when its last sample has been taken.
  while (next_ + (format_.samples - 1) * sample_time_ <= now) {
    const std::vector<std::uint8_t> packet = nextPacket();
    const Timestamp taken = next_ - sample_time_;
    if (line_.empty()) line_begin_ = taken;
    line_.insert(line_.end(), packet.begin(), packet.end());
  }
  for (; !line_.empty() && line_begin_ + byte_time_ <= now; line_begin_ += byte_time_) {
    out.push_back(line_.front());
    line_.pop_front();
  }
}

}  // namespace slam::sim
