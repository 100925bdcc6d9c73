// SPDX-License-Identifier: BSD-3-Clause
// The front end's reference and what the back end lists of it: two threads, one map.
#include "frontend/map_correction.hpp"

#include <algorithm>
#include <cmath>
#include <gtest/gtest.h>
#include <numbers>
#include <random>
#include <set>

#include "slam/robot.hpp"
#include "support/simulated/keyframes.hpp"

namespace slam::map_correction_test {
namespace {

using test::Robot;

constexpr double kSide = 12.0, kOtherSide = 8.0;  // [m] of the way around the ring corridor

/// Around the block twice and a bit.
void round(Robot& robot) {
  robot.run(1.0, {0, 0, 0});
  for (const double side : {kSide - 1.0, kOtherSide, kSide, kOtherSide, kSide, kOtherSide, kSide, kOtherSide, kSide}) {
    robot.drive(side);
    robot.turn(std::numbers::pi / 2);
  }
}

class LateCorrections : public testing::TestWithParam<unsigned> {
 protected:
  /// What the front end matches against is what the back end says, where nothing is on its way.
  void expectOneMap() {
    std::set<int> held, listed;
    for (const ReferenceKeyframe& keyframe : robot.pipeline.frontEnd().referenceKeyframes()) held.insert(keyframe.id);
    for (int id = 0; id < robot.pipeline.backEnd().keyframes().size(); ++id) {
      if (robot.pipeline.backEnd().inReference(id)) listed.insert(id);
    }
    ASSERT_EQ(held, listed);
    for (const ReferenceKeyframe& keyframe : robot.pipeline.frontEnd().referenceKeyframes()) {
      const Pose2 apart = between(robot.pipeline.backEnd().keyframes().pose(keyframe.id), keyframe.T_map_base);
      ASSERT_LT(std::hypot(apart.x, apart.y), BackEndConfig{}.renewal_shift) << keyframe.id;
    }
    ++compared;
  }

  /// The reference is small, so that it is renewed often.
  static BackEndConfig nearsighted() {
    BackEndConfig config;
    config.reference_radius = 5.0;
    config.renewal_radius = 4.0;
    return config;
  }

  Robot robot{test::ringCorridor(), test::onRing(1.0), false, MapState(), nearsighted()};
  std::mt19937 random{GetParam()};
  int compared = 0, most_ahead = 0, corrections = 0;
};

TEST_P(LateCorrections, LeaveFrontEndAndBackEndWithTheSameKeyframesInTheSamePlaces) {
  bool graph_works = false, handed_over = true;
  const auto chance = [this](double share) { return std::bernoulli_distribution(share)(random); };
  robot.keyframe_waits = [&] {
    graph_works = graph_works ? !chance(0.2) : chance(0.2);
    return graph_works;
  };
  robot.correction_waits = [&] {
    if (handed_over) ++corrections;
    handed_over = chance(0.04);
    if (!handed_over) return true;
    int ahead = static_cast<int>(std::count_if(robot.keyframes.begin(), robot.keyframes.end(),
                                               [](const Keyframe& keyframe) { return !keyframe.refresh; }));
    ahead += robot.pipeline.backEnd().keyframes().size() - 1 - robot.pipeline.correction()->newest;
    most_ahead = std::max(most_ahead, ahead);
    return false;
  };
  robot.after_scan = [&] {
    if (!HasFatalFailure() && robot.pipeline.correction() == nullptr && robot.keyframes.empty()) expectOneMap();
  };
  round(robot);
  EXPECT_GT(corrections, 10);
  EXPECT_GT(most_ahead, 4);
  EXPECT_GT(compared, 100);
  EXPECT_GT(robot.pipeline.backEnd().counters().loop_closures, 0);
  EXPECT_EQ(robot.state(), LocalisationState::kLocalised);
  EXPECT_LT(robot.error(test::onRing(1.0)), 0.15);
}

INSTANTIATE_TEST_SUITE_P(AtRandom, LateCorrections, testing::Values(1U, 2U, 3U));

}  // namespace
}  // namespace slam::map_correction_test
