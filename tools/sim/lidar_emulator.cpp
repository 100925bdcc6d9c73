// SPDX-License-Identifier: BSD-3-Clause
#include "tools/sim/lidar_emulator.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace slam::sim {
namespace {

using rplidar::AnswerType;
using rplidar::Request;

constexpr std::uint8_t kModel = 0x18, kFirmwareMinor = 0x1D, kFirmwareMajor = 0x01, kHardware = 7;

void answer(AnswerType type, std::initializer_list<std::uint8_t> data, std::vector<std::uint8_t>& out) {
  const auto descriptor =
      rplidar::encodeDescriptor({static_cast<std::uint32_t>(data.size()), false, static_cast<std::uint8_t>(type)});
  out.insert(out.end(), descriptor.begin(), descriptor.end());
  out.insert(out.end(), data.begin(), data.end());
}

void announceStream(AnswerType type, std::size_t size, std::vector<std::uint8_t>& out) {
  const auto descriptor =
      rplidar::encodeDescriptor({static_cast<std::uint32_t>(size), true, static_cast<std::uint8_t>(type)});
  out.insert(out.end(), descriptor.begin(), descriptor.end());
}

/// Correction of a sample's angle for its distance [deg], as the unit's triangulation makes it.
double angleOffset(double range_mm) {
  if (range_mm < 50.0) return 7.5;
  const double k = std::floor(98361.0 / (range_mm * 4.0));
  const double q16 = std::floor(8.0 * std::numbers::pi / 180.0 * 65536.0) - 64.0 * k - k * k * k / 98304.0;
  return q16 / 65536.0 * 180.0 / std::numbers::pi;
}

double bearingOf(double clockwise_degrees) { return -clockwise_degrees * std::numbers::pi / 180.0; }

}  // namespace

double LidarEmulator::rawAngle(std::int64_t sample) const {
  const double per_sample = 1e-6 * (mode_ == Mode::kExpress ? kExpressUs : kStandardUs);
  return 360.0 * std::fmod(turn_rate_ * per_sample * static_cast<double>(sample), 1.0);
}

void LidarEmulator::receive(std::span<const std::uint8_t> bytes, Timestamp now, std::vector<std::uint8_t>& out) {
  for (const std::uint8_t byte : bytes) {
    if (request_.empty() && byte != 0xA5) continue;
    request_.push_back(byte);
    if (request_.size() < 2) continue;
    const bool has_payload = request_[1] & 0x80;
    if (has_payload && (request_.size() < 3 || request_.size() < 4U + request_[2])) continue;
    handle(static_cast<Request>(request_[1]), now, out);
    request_.clear();
  }
}

void LidarEmulator::handle(Request request, Timestamp now, std::vector<std::uint8_t>& out) {
  mode_ = Mode::kIdle;  // any request ends a scan
  switch (request) {
    case Request::kGetInfo:
      answer(AnswerType::kInfo, {kModel, kFirmwareMinor, kFirmwareMajor, kHardware, 0x53, 0x4C, 0x41, 0x4D, 0x44, 0x2D,
                                 0x53,   0x49,           0x4D,           0x2D,      0x30, 0x30, 0x30, 0x30, 0x30, 0x31},
             out);
      break;
    case Request::kGetHealth:
      answer(AnswerType::kHealth, {0, 0, 0}, out);
      break;
    case Request::kGetSampleRate:
      answer(AnswerType::kSampleRate, {kStandardUs & 0xFF, kStandardUs >> 8, kExpressUs & 0xFF, kExpressUs >> 8}, out);
      break;
    case Request::kScan:
      announceStream(AnswerType::kStandardNodes, rplidar::kStandardNodeSize, out);
      startScan(Mode::kStandard, now);
      break;
    case Request::kExpressScan:
      announceStream(AnswerType::kExpressCapsules, rplidar::kExpressCapsuleSize, out);
      startScan(Mode::kExpress, now);
      break;
    case Request::kReset: {
      const std::string_view banner = "RP LIDAR System.\r\nFirmware Ver 1.29 - rtm, HW Ver 7\r\nModel: 18\r\n";
      out.insert(out.end(), banner.begin(), banner.end());
      break;
    }
    default:  // STOP and motor commands have no answer
      break;
  }
}

void LidarEmulator::startScan(Mode mode, Timestamp now) {
  mode_ = mode;
  started_ = now;
  sample_ = 0;
}

void LidarEmulator::stream(Timestamp now, std::vector<std::uint8_t>& out) {
  if (mode_ == Mode::kIdle) return;
  const bool express = mode_ == Mode::kExpress;
  const Duration per_sample = std::chrono::microseconds(express ? kExpressUs : kStandardUs);
  // A sample leaves the unit's filter one sample after it was taken.
  const auto taken = [&](std::int64_t k) { return started_ + k * per_sample; };
  if (!express) {
    for (; taken(sample_ + 2) <= now; ++sample_) {
      const double angle = rawAngle(sample_);
      const double range = measure_(taken(sample_), bearingOf(angle));
      const bool start = sample_ > 0 && angle < rawAngle(sample_ - 1);
      const auto node =
          rplidar::encodeStandardNode({.angle_q6 = static_cast<std::uint16_t>(std::lround(angle * 64) % 23040),
                                       .distance_q2 = static_cast<std::uint32_t>(std::lround(range * 4000.0)),
                                       .quality = static_cast<std::uint8_t>(range > 0.0 ? 15 : 0),
                                       .start = start});
      out.insert(out.end(), node.begin(), node.end());
    }
    return;
  }
  while (taken(sample_ + rplidar::kExpressSamples + 1) <= now) {
    rplidar::ExpressCapsule capsule;
    capsule.start = sample_ == 0;
    capsule.start_angle_q6 = static_cast<std::uint16_t>(std::lround(rawAngle(sample_) * 64) % 23040);
    for (auto& sample : capsule.samples) {
      // The unit reports a beam at raw angle minus an offset that depends on its distance: find the beam that fits.
      const double raw = rawAngle(sample_);
      double offset = angleOffset(4000.0), range = 0.0;
      for (int i = 0; i < 2; ++i) {
        range = measure_(taken(sample_), bearingOf(raw - offset));
        if (range > 0.0) offset = std::round(angleOffset(1000.0 * range) * 8.0) / 8.0;
      }
      sample.distance_mm = static_cast<std::uint16_t>(std::clamp(std::lround(range * 1000.0), 0L, 16383L));
      sample.offset_q3 = static_cast<std::uint8_t>(range > 0.0 ? std::clamp(std::lround(offset * 8.0), 0L, 63L) : 0L);
      ++sample_;
    }
    const auto bytes = rplidar::encodeExpressCapsule(capsule);
    out.insert(out.end(), bytes.begin(), bytes.end());
  }
}

}  // namespace slam::sim
