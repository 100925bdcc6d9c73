// SPDX-License-Identifier: BSD-3-Clause
#include "slam/loop_closer.hpp"

#include <gtest/gtest.h>
#include <memory>

#include "support/simulated/keyframes.hpp"

namespace slam::loop_closer_test {
namespace {

const Eigen::Vector3d kDrift(0.01, 0.01, 0.002);  // [m, m, rad] a step

/// Once around the ring corridor and a bit. @param first_in_map keyframes before it are not part of the map
struct Round {
  explicit Round(int first_in_map) {
    for (double s = 1.0; s < 48.0; s += 0.5) {
      map.add(drive.at(test::onRing(s), kDrift), map.keyframes.size() >= first_in_map);
      const int generation = map.generation;
      const Pose2 first = map.keyframes.pose(0);
      closer->close(map);
      if (map.generation == generation) {
        EXPECT_EQ(map.keyframes.pose(0), first);
      }
      closer->addTo(counters);
    }
  }
  test::KeyframeDrive drive{test::ringCorridor(), 2};
  KeyframeMap map;
  std::unique_ptr<LoopCloser> closer = std::make_unique<LoopCloser>(BackEndConfig{});
  BackEndCounters counters;
};

TEST(LoopCloser, BringsTheEndOfARoundToItsBeginning) {
  const Round round(0);
  EXPECT_GT(round.counters.loop_closures, 0);
  EXPECT_GT(round.map.generation, 0);
  EXPECT_GE(round.counters.optimisations, round.map.generation);
  EXPECT_EQ(round.counters.search.accepted, round.counters.loop_closures + round.counters.revoked);
  const int last = round.map.newest();
  const Pose2 error =
      between(round.drive.trueRelative(0, last), between(round.map.keyframes.pose(0), round.map.keyframes.pose(last)));
  const Pose2 drifted =
      between(round.drive.trueRelative(0, last), between(round.drive.measured.front(), round.drive.measured.back()));
  EXPECT_LT(error.translation().norm(), 0.15);
  EXPECT_LT(error.translation().norm(), drifted.translation().norm());
}

TEST(LoopCloser, MeetsNoKeyframeThatIsNoPartOfTheMap) {
  const Round round(60);
  EXPECT_EQ(round.counters.loop_closures, 0);
  EXPECT_EQ(round.map.generation, 0);
}

}  // namespace
}  // namespace slam::loop_closer_test
