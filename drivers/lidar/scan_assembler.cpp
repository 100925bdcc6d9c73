// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/lidar/scan_assembler.hpp"

#include <algorithm>
#include <numbers>

#include "core/pose2.hpp"

namespace slam {
namespace {

constexpr int kTurnQ6 = 360 * 64;
constexpr int kLongestTurnQ6 = kTurnQ6 + 30 * 64;  // corrections shift its first and last node against each other

int wrapQ6(int angle) { return angle - (2 * angle >= kTurnQ6 ? kTurnQ6 : 2 * angle < -kTurnQ6 ? -kTurnQ6 : 0); }

/// Places beams without echo between the echoes around them. @param sense -1: bearings fall from beam to beam, 1: they
/// rise
class EvenPlaces {
 public:
  EvenPlaces(std::span<Beam> beams, double sense) : beams_(beams), sense_(sense) {}

  void place() {
    const std::size_t size = beams_.size();
    const double step = 2.0 * std::numbers::pi / static_cast<double>(size);
    std::size_t echo = nextEcho(0);
    if (echo == size) return;
    spread(0, echo, beams_[echo].bearing - sense_ * static_cast<double>(echo + 1) * step, step);
    while (echo < size) {
      const std::size_t first = echo + 1, next = nextEcho(first);
      if (next == size) {
        spread(first, size, beams_[echo].bearing, step);
      } else if (next > first) {
        // In order already: nothing is wrong with them.
        const bool ordered = turned(echo, first) >= 0.0 && turned(next - 1, next) >= 0.0;
        const double expected = step * static_cast<double>(next - echo);
        const double angle = expected + wrapAngle(turned(echo, next) - expected);
        if (!ordered && angle > 0.0)
          spread(first, next, beams_[echo].bearing, angle / static_cast<double>(next - echo));
      }
      echo = next;
    }
  }

 private:
  /// Angle that the head turned from one beam to another [rad], in (-pi, pi].
  double turned(std::size_t from, std::size_t to) const {
    return sense_ * wrapAngle(beams_[to].bearing - beams_[from].bearing);
  }
  std::size_t nextEcho(std::size_t i) const {
    while (i < beams_.size() && beams_[i].range <= 0.0F) ++i;
    return i;
  }
  /// Places the beams [first, last) at an even step behind `bearing`.
  void spread(std::size_t first, std::size_t last, double bearing, double step) {
    for (std::size_t i = first; i < last; ++i) {
      bearing += sense_ * step;
      beams_[i].bearing = static_cast<float>(wrapAngle(bearing));
    }
  }

  std::span<Beam> beams_;
  double sense_;
};

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
  if (places_) EvenPlaces({finished_.storage.data(), static_cast<std::size_t>(finished_.size)}, sense_).place();
  return &finished_;
}

const LaserScan* ScanAssembler::endTurn() {
  const LaserScan* done = whole_ && scan_.size > 0 ? finish() : nullptr;
  reset();
  return done;
}

const LaserScan* ScanAssembler::add(const LidarNode& node, Timestamp stamp) {
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
                  .bearing = static_cast<float>(wrapAngle(sense_ * node.angle_q6 * kRadiansPerQ6)),
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

}  // namespace slam
