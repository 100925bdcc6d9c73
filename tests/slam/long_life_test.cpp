// SPDX-License-Identifier: BSD-3-Clause
// A working day in a known room costs nothing: no keyframe, edge, tile or byte of heap more than its first minutes.
#include <cmath>
#include <gtest/gtest.h>
#include <malloc.h>
#include <numbers>
#include <random>
#include <vector>

#include "matching/places.hpp"
#include "slam/pipeline.hpp"

namespace slam::long_life_test {
namespace {

using namespace std::chrono_literals;

#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
constexpr double kHours = 0.5;  // many times slower, and with an allocator of its own
constexpr bool kHeapIsKnown = false;
#else
constexpr double kHours = 8.0;
constexpr bool kHeapIsKnown = true;
#endif
constexpr int kBeams = 120, kLapScans = 96, kNoises = 4;
constexpr Duration kTurn = 200ms;          // of the lidar
constexpr double kRadius = 0.9;            // [m] of a lap
constexpr std::size_t kHeapSlack = 65536;  // [bytes] of buffers that come and go

Pose2 onLap(int scan) {
  const double angle = 2.0 * std::numbers::pi * scan / kLapScans;
  return {kRadius * std::sin(angle), -kRadius * std::cos(angle), wrapAngle(angle)};
}

/// The pipeline, fed with scans that were cast once.
class Day {
 public:
  Day() {
    const test::Place room = test::furnishedRoom();
    std::mt19937 random(1);
    for (int i = 0; i < kNoises * kLapScans; ++i) {
      scans_.push_back(test::SimulatedLidar{.beams = kBeams}.scan(room, onLap(i % kLapScans), random));
    }
  }

  void stand(double seconds) {
    for (const Timestamp end = now_ + fromSeconds(seconds); now_ < end;) {
      step(Pose2{}, at_);
      noise_ = (noise_ + 1) % kNoises;
    }
  }
  void laps(double count) {
    const Pose2 motion = between(onLap(0), onLap(1));
    for (int left = static_cast<int>(count * kLapScans); left > 0; --left) {
      at_ = (at_ + 1) % kLapScans;
      if (at_ == 0) noise_ = (noise_ + 1) % kNoises;
      step(Pose2::fromVector({1.01 * motion.x, motion.y, 0.99 * motion.theta}), at_);
    }
  }

  struct Size {
    int keyframes, edges, tiles, drawn;
    std::size_t heap;
  };
  Size size() {
    return {pipeline_.backEnd().keyframes().size(),
            static_cast<int>(pipeline_.backEnd().keyframes().graph().edges().size()),
            pipeline_.mapper().grid().tiles().tileCount(), pipeline_.mapper().keyframes(), mallinfo2().uordblks};
  }
  double error() const {
    return (pipeline_.frontEnd().estimate(now_).T_map_base.translation() - between(onLap(0), onLap(at_)).translation())
        .norm();
  }
  LocalisationState state() const { return pipeline_.frontEnd().estimate(now_).state; }

 private:
  void step(const Pose2& motion, int at) {
    for (int half = 0; half < 2; ++half) {
      now_ += kTurn / 2;
      if (half == 1) wheels_ = wheels_ * motion;
      pipeline_.add(WheelSample{now_, half == 1 ? wheels_ : wheels_ * exp(0.5 * slam::log(motion))});
      pipeline_.add(ImuSample{now_, {0, 0, motion.theta / toSeconds(kTurn) + 0.01}, {0, 0, 9.81}});
    }
    LaserScan& scan = scans_[static_cast<std::size_t>(noise_ * kLapScans + at)];
    scan.stamp = now_;
    pipeline_.add(scan);
  }

  std::vector<LaserScan> scans_;
  Pipeline pipeline_{{}};
  Timestamp now_{100s};
  Pose2 wheels_;
  int at_ = 0, noise_ = 0;
};

TEST(LongLife, AKnownRoomCostsNothing) {
  Day day;
  day.stand(60.0);
  EXPECT_EQ(day.size().keyframes, 1) << "nothing new is seen from one place";
  day.laps(40.0);  // of a third of a minute: all is seen but for a point here and there
  const Day::Size known = day.size();
  EXPECT_GT(known.keyframes, 3);
  constexpr int kParts = 8;
  const double part = 3600.0 * kHours / kParts;
  for (int i = 0; i < kParts; ++i) {
    i < 2 ? day.stand(part) : day.laps(part / (kLapScans * toSeconds(kTurn)));
    const Day::Size now = day.size();
    EXPECT_EQ(now.keyframes, known.keyframes) << i;
    EXPECT_EQ(now.edges, known.edges) << i;
    EXPECT_EQ(now.drawn, known.drawn) << i;
    EXPECT_EQ(now.tiles, known.tiles) << i;
    if (kHeapIsKnown) {
      EXPECT_LT(now.heap, known.heap + kHeapSlack) << i;
    }
    EXPECT_LT(day.error(), 0.05) << i;
    EXPECT_EQ(day.state(), LocalisationState::kLocalised) << i;
  }
}

}  // namespace
}  // namespace slam::long_life_test
