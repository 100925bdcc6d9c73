// SPDX-License-Identifier: BSD-3-Clause
#include "tools/sim/lidar/lidar_emulator.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "drivers/lidar/codec/rplidar_modes.hpp"
#include "drivers/lidar/rplidar_stream.hpp"

namespace slam::sim {
namespace {

using namespace std::chrono_literals;
using rplidar::AnswerType;

constexpr Duration kBoot = 670ms, kAfterBanner = 4ms;  // of a real unit

}  // namespace

LidarEmulator::LidarEmulator(Measure measure, double turn_rate, LidarIdentity identity)
    : measure_(std::move(measure)),
      sampler_(turn_rate),
      identity_(std::move(identity)),
      byte_time_(fromSeconds(10.0 / identity_.baud)) {}

void LidarEmulator::startScan(AnswerType type, double sample_us, Timestamp now, std::vector<std::uint8_t>& out) {
  const auto format = rplidar::packetFormat(static_cast<std::uint8_t>(type));
  if (!format || faults_.health == 2) return;
  const auto descriptor =
      rplidar::encodeDescriptor({static_cast<std::uint32_t>(format->size), true, static_cast<std::uint8_t>(type)});
  out.insert(out.end(), descriptor.begin(), descriptor.end());
  sampler_.begin(type, static_cast<std::size_t>(format->samples), fromSeconds(1e-6 * sample_us), now);
}

void LidarEmulator::Sampler::begin(AnswerType type, std::size_t packet_samples, Duration sample_time, Timestamp now) {
  encoder_.emplace(type);
  packet_samples_ = packet_samples;
  // An ultra capsule ends with a difference to the first distance of the next one.
  needed_samples_ = packet_samples_ + (type == AnswerType::kUltraCapsules ? 1 : 0);
  sample_time_ = sample_time;
  started_ = now;
  sample_ = 0;
  samples_.clear();
  s_bit_ = true;
}

void LidarEmulator::boot(Timestamp now) {
  sampler_.end();
  const std::string banner = "RP LIDAR System.\r\nFirmware Ver " + std::to_string(identity_.firmware >> 8) + "." +
                             std::to_string(identity_.firmware & 0xFF) + " - rtm, HW Ver " +
                             std::to_string(identity_.hardware) + "\r\nModel: " + std::to_string(identity_.model) +
                             "\r\n";
  line_.assign(banner.begin(), banner.end());
  line_begin_ = now + kBoot - static_cast<std::int64_t>(banner.size()) * byte_time_;
  ready_at_ = now + kBoot + kAfterBanner;
  pwm_ = speed_ = 0;
}

void LidarEmulator::beginFaults(Timestamp now) {
  if (const auto unit = std::exchange(faults_.unit, std::nullopt)) {
    identity_ = *unit;
    byte_time_ = fromSeconds(10.0 / identity_.baud);
    faults_.reboot = true;
  }
  if (std::exchange(faults_.reboot, false)) boot(now);
  if (faults_.pause > Duration(0)) paused_until_ = now + std::exchange(faults_.pause, Duration(0));
  if (faults_.turn > Duration(0)) sampler_.setTurnRate(1.0 / toSeconds(faults_.turn));
  if (faults_.health == 2) sampler_.end();
}

bool LidarEmulator::turning(Timestamp now) const {
  const bool driven = identity_.accessory_board ? pwm_ > 0 : !hasSpeedControl() || speed_ > 0;
  return !faults_.stalled && driven && now >= stable_at_;
}

void LidarEmulator::stream(Timestamp now, std::vector<std::uint8_t>& out) {
  beginFaults(now);
  if (faults_.other != OtherLidar::kNone) {
    other_.stream(
        static_cast<OtherLidar::Make>(faults_.other), now, [&](double bearing) { return measure_(now, bearing); }, out);
  }
  if (faults_.silent || faults_.other != OtherLidar::kNone) {
    line_.clear();
    sampler_.skipTo(now);
    return;
  }
  if (now < paused_until_ || !turning(now)) {
    sampler_.skipTo(now);
  } else {
    makePackets(now, out);
  }
  sendOn(now, out);
}

void LidarEmulator::Sampler::skipTo(Timestamp now) {
  if (!isOn()) return;
  samples_.clear();
  const std::int64_t reached = std::max(sample_, (now - started_) / sample_time_);
  angle_ += turn_rate_ * toSeconds((reached - sample_) * sample_time_);
  angle_ -= std::floor(angle_);
  sample_ = reached;
}

void LidarEmulator::Sampler::take(bool stuck, const LookAt& look_at) {
  if (first_of_turn_) {
    if (!repeating_) std::swap(turn_, last_turn_);
    turn_.clear();
    repeating_ = stuck && !last_turn_.empty();
  }
  const std::size_t place = turn_.size();
  if (repeating_ && place < last_turn_.size()) {
    turn_.push_back(last_turn_[place]);
    first_of_turn_ = false;
  } else {
    turn_.push_back(encoder_->take(360.0 * angle_, std::exchange(first_of_turn_, false), look_at(taken(sample_))));
  }
  samples_.push_back(turn_.back());
  ++sample_;
  angle_ += turn_rate_ * toSeconds(sample_time_);
  if (angle_ < 1.0) return;
  angle_ -= std::floor(angle_);
  first_of_turn_ = true;
}

void LidarEmulator::Sampler::resetEncoder() {
  sample_ -= static_cast<std::int64_t>(samples_.size());
  samples_.clear();
  angle_ = 0.0;
  s_bit_ = first_of_turn_ = true;
}

Timestamp LidarEmulator::Sampler::due() const {
  // The last sample of a packet is measured for half its time, and leaves the unit's filter one sample later.
  const std::int64_t first = sample_ - static_cast<std::int64_t>(samples_.size());
  return taken(first + static_cast<std::int64_t>(packet_samples_) - 1) + sample_time_ * 3 / 2;
}

std::vector<std::uint8_t> LidarEmulator::Sampler::makePacket(bool stuck, const LookAt& look_at) {
  while (samples_.size() < needed_samples_) take(stuck, look_at);
  std::vector<std::uint8_t> packet = encoder_->pack(samples_, std::exchange(s_bit_, false));
  samples_.erase(samples_.begin(), samples_.begin() + static_cast<std::ptrdiff_t>(packet_samples_));
  return packet;
}

void LidarEmulator::makePackets(Timestamp now, std::vector<std::uint8_t>& out) {
  const auto look_at = [this](Timestamp stamp) -> LidarEncoder::Look {
    return [this, stamp, fate = faults_.nextFate()](double clockwise) {
      return faults_.range_factor * fate.of(measure_(stamp, -clockwise * std::numbers::pi / 180.0));
    };
  };
  while (scanning()) {
    if (std::exchange(faults_.encoder_reset, false)) sampler_.resetEncoder();
    const Timestamp due = sampler_.due();
    if (due > now) return;
    std::vector<std::uint8_t> packet = sampler_.makePacket(faults_.stuck, look_at);
    faults_.damage(packet, sampler_.isCapsule());
    sendOn(due, out);
    if (line_.empty()) line_begin_ = std::max(line_begin_, due);
    line_.insert(line_.end(), packet.begin(), packet.end());
  }
}

void LidarEmulator::sendOn(Timestamp now, std::vector<std::uint8_t>& out) {
  for (; !line_.empty() && line_begin_ + byte_time_ <= now; line_begin_ += byte_time_) {
    out.push_back(line_.front());
    line_.pop_front();
  }
}

}  // namespace slam::sim
