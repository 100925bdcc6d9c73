// SPDX-License-Identifier: BSD-3-Clause
#include "frontend/interpreter/echo_watch.hpp"

#include <gtest/gtest.h>
#include <random>

namespace slam::echo_watch_test {
namespace {

using namespace std::chrono_literals;
using Finding = EchoWatch::Finding;
constexpr Timestamp kStart{100s};
const RangeLimits kLimits{0.15F, 12.0F};

/// A lidar of five turns a second. @param share of its beams have `range`, the others `otherwise` [m]
class Lidar {
 public:
  void turn(double seconds, double share, float range = 3.0F, float otherwise = 0.0F) {
    for (const Timestamp end = now_ + fromSeconds(seconds); now_ < end; now_ += 200ms) {
      scan_.size = 0;
      std::bernoulli_distribution comes_back(share);
      for (int i = 0; i < 1000; ++i) scan_.push({.range = comes_back(random_) ? range : otherwise});
      watch_.add(scan_, kLimits, now_);
    }
  }
  const EchoWatch& watch() const { return watch_; }

 private:
  std::mt19937 random_{1};
  LaserScan scan_;
  EchoWatch watch_;
  Timestamp now_ = kStart;
};

TEST(EchoWatch, FindsThatOneBeamInTwentyComesBackOnceThatLasts) {
  for (const double share : {0.05, 0.02, 0.0}) {
    Lidar lidar;
    lidar.turn(4.9, share);
    EXPECT_EQ(lidar.watch().finding(), Finding::kNone) << share;
    lidar.turn(0.5, share);
    EXPECT_EQ(lidar.watch().finding(), Finding::kNoEcho) << share;
    EXPECT_NEAR(lidar.watch().share(), share, 0.03);
    lidar.turn(0.2, 0.5);
    EXPECT_EQ(lidar.watch().finding(), Finding::kNone) << "the cover is off";
  }
}

TEST(EchoWatch, IsContentWithAnOpenSpace) {
  Lidar lidar;
  lidar.turn(60.0, 0.1);
  EXPECT_EQ(lidar.watch().finding(), Finding::kNone);
}

TEST(EchoWatch, TakesNoSingleTurnForLasting) {
  Lidar lidar;
  for (int i = 0; i < 20; ++i) {
    lidar.turn(4.0, 0.0);
    lidar.turn(0.2, 0.5);
    ASSERT_EQ(lidar.watch().finding(), Finding::kNone);
  }
}

TEST(EchoWatch, DistinguishesRangesBeyondTheLimitsFromNone) {
  Lidar near, far;
  near.turn(6.0, 0.02, 3.0F, 0.05F);
  far.turn(6.0, 0.02, 3.0F, 3000.0F);
  EXPECT_EQ(near.watch().finding(), Finding::kNear);
  EXPECT_EQ(far.watch().finding(), Finding::kFar);
}

}  // namespace
}  // namespace slam::echo_watch_test
