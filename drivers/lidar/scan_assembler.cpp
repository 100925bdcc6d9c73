// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/lidar/scan_assembler.hpp"

#include <algorithm>
#include <numbers>

#include "core/pose2.hpp"

namespace slam::rplidar {
namespace {

constexpr int kTurnQ6 = 360 * 64;
constexpr int kLongestTurnQ6 = kTurnQ6 + 30 * 64;  // corrections shift its first and last node against each other

int wrapQ6(int angle) { return angle - (2 * angle >= kTurnQ6 ? kTurnQ6 : 2 * angle < -kTurnQ6 ? -kTurnQ6 : 0); }

/// Clockwise angle from one beam to another [rad], in (-pi, pi].
double turnedBetween(const Beam& from, const Beam& to) { return -wrapAngle(to.bearing - from.bearing); }

/// Places the beams [first, last) at an even clockwise step behind `bearing`.
void spread(std::span<Beam> beams, std::size_t first, std::size_t last, double bearing, double step) {
  for (std::size_t i = first; i < last; ++i) {
    bearing -= step;
    beams[i].bearing = static_cast<float>(wrapAngle(bearing));
  }
}

void placeBeamsWithoutEcho(std::span<Beam> beams) {
  const std::size_t size = beams.size();
  const double step = 2.0 * std::numbers::pi / static_cast<double>(size);
  const auto next_echo = [&](std::size_t i) {
    while (i < size && beams[i].range <= 0.0F) ++i;
    return i;
  };
  std::size_t echo = next_echo(0);
  if (echo == size) return;
  spread(beams, 0, echo, beams[echo].bearing + static_cast<double>(echo + 1) * step, step);
  while (echo < size) {
    const std::size_t first = echo + 1, next = next_echo(first);
    if (next == size) {
      spread(beams, first, size, beams[echo].bearing, step);
    } else if (next > first) {
      // In order already: nothing is wrong with them.
      const bool ordered =
          turnedBetween(beams[echo], beams[first]) >= 0.0 && turnedBetween(beams[next - 1], beams[next]) >= 0.0;
      const double expected = step * static_cast<double>(next - echo);
      const double turned = expected + wrapAngle(turnedBetween(beams[echo], beams[next]) - expected);
      if (!ordered && turned > 0.0)
        spread(beams, first, next, beams[echo].bearing, turned / static_cast<double>(next - echo));
    }
    echo = next;
  }
}

}  // namespace

void ScanAssembler::reset() {
  whole_ = false;
  scan_.size = 0;
}

const LaserScan* ScanAssembler::finish() {
  finished_stride_ = stride_;
  finished_.stamp = scan_.stamp;
  finished_.range_min = scan_.range_min;
  finished_.range_max = scan_.range_max;
  finished_.size = scan_.size;
  std::copy_n(scan_.storage.begin(), scan_.size, finished_.storage.begin());
  placeBeamsWithoutEcho({finished_.storage.data(), static_cast<std::size_t>(finished_.size)});
  return &finished_;
}

const LaserScan* ScanAssembler::add(const Node& node, Timestamp stamp) {
  const LaserScan* done = nullptr;
  turned_q6_ += wrapQ6(node.angle_q6 - last_angle_q6_);
  last_angle_q6_ = node.angle_q6;
  if (node.start) {
    ++turns_;
    if (whole_ && scan_.size > 0) done = finish();
    whole_ = true;
    scan_.size = 0;
    turned_q6_ = 0;
    stride_ = 1;
    skip_ = 0;
  }
  if (!whole_) return nullptr;
  if (turned_q6_ > kLongestTurnQ6) {
    ++broken_;
    ++turns_;
    reset();
    return nullptr;
  }
  if (scan_.size == 0) scan_.stamp = stamp;
  constexpr double kRadiansPerQ6 = std::numbers::pi / (180.0 * 64.0);
  const Beam beam{.range = static_cast<float>(node.distance_q2) * 0.25e-3F,
                  .bearing = static_cast<float>(wrapAngle(-node.angle_q6 * kRadiansPerQ6)),  // clockwise there
                  .time_offset = static_cast<float>(toSeconds(stamp - scan_.stamp)),
                  .intensity = static_cast<float>(node.quality)};
  push(beam);
  return done;
}

/// How many nodes a turn has is known at its end: when the scan is full every second beam goes, and from then on every
/// second node is left out.
void ScanAssembler::push(const Beam& beam) {
  if (skip_ > 0) {
    --skip_;
    ++thinned_;
    return;
  }
  if (scan_.size == LaserScan::kCapacity) {
    static_assert(LaserScan::kCapacity % 2 == 0, "else the next node is not in step");
    for (std::size_t i = 1; i < LaserScan::kCapacity / 2; ++i) scan_.storage[i] = scan_.storage[2 * i];
    scan_.size /= 2;
    thinned_ += scan_.size;
    stride_ *= 2;
  }
  scan_.push(beam);
  skip_ = stride_ - 1;
}

}  // namespace slam::rplidar
