// SPDX-License-Identifier: BSD-3-Clause
#include "relocalisation/relocalisation.hpp"

#include <gtest/gtest.h>
#include <numeric>

#include "support/simulated/keyframes.hpp"

namespace slam::test {
namespace {

constexpr double kRight = 0.1;  // [m]
const Eigen::Vector3d kStep(0.002, 0.002, 0.0005);

/// A map of keyframes at the poses given, and a robot that drives in it without knowing where it began.
class LostRobot {
 public:
  LostRobot(const Place& place, const std::vector<Pose2>& map_poses, unsigned seed = 1)
      : map_drive_(place, seed), drive_(place, seed + 100), relocalisation_({}, {}, {}) {
    for (const Pose2& pose : map_poses) {
      const Keyframe& keyframe = map_drive_.at(pose, Pose2{}, kStep);
      keyframes_.add(std::make_shared<const StoredScan>(keyframe), pose);
    }
    map_size_ = keyframes_.size();
    std::vector<int> ids(static_cast<std::size_t>(map_size_));
    std::iota(ids.begin(), ids.end(), 0);
    relocalisation_.begin(keyframes_, ids);
  }

  /// @return the place believed, if any
  std::optional<Pose2> at(const Pose2& truth) {
    const Keyframe& keyframe = drive_.at(truth, kStep);
    keyframes_.add(std::make_shared<const StoredScan>(keyframe), keyframe.T_map_base);
    const auto found = relocalisation_.search(keyframes_, map_size_, keyframes_.size() - 1);
    return found ? std::optional(found->T_map_newest) : std::nullopt;
  }

 private:
  KeyframeDrive map_drive_, drive_;
  KeyframeGraph keyframes_;
  Relocalisation relocalisation_;
  int map_size_ = 0;
};

std::vector<Pose2> ringPoses() {
  std::vector<Pose2> poses;
  for (double s = 0.0; s < 40.0; s += 0.5) poses.push_back(onRing(s));
  return poses;
}

TEST(Relocalisation, IsNeverWrongOnTheRingAndMostlyRight) {
  int right = 0, wrong = 0;
  for (int start = 0; start < 12; ++start) {
    LostRobot robot(ringCorridor(), ringPoses(), static_cast<unsigned>(start + 1));
    for (int step = 0; step < 16; ++step) {
      const Pose2 truth = onRing(3.3 * start + 0.4 * step);
      if (const auto found = robot.at(truth)) {
        const Pose2 error = between(truth, *found);
        ++(std::hypot(error.x, error.y) < kRight && std::abs(error.theta) < 0.1 ? right : wrong);
        break;
      }
    }
  }
  EXPECT_EQ(wrong, 0);
  EXPECT_GE(right, 10);
}

TEST(Relocalisation, SaysNothingInOneOfTwoRoomsThatAreAlike) {
  std::vector<Pose2> map;
  for (const double x : {0.0, kTwins}) {
    for (double s = -1.0; s <= 2.0; s += 0.5) map.push_back({x + s, 0.0, 0.0});
  }
  LostRobot robot(twins(), map);
  for (double s = -1.0; s <= 2.0; s += 0.25) EXPECT_FALSE(robot.at({s, 0.1, 0.0}));
}

TEST(Relocalisation, SaysNothingInAPeriodicCorridor) {
  std::vector<Pose2> map;
  for (double x = -18.0; x <= 18.0; x += 0.5) map.push_back({x, 0.0, 0.0});
  LostRobot robot(corridorWithDoors(), map);
  for (double x = -2.0; x <= 4.0; x += 0.4) EXPECT_FALSE(robot.at({x, 0.05, 0.0}));
}

TEST(Relocalisation, KnowsTheDoorsOfItsOwnMapFromThoseThatAreNotInIt) {
  int right = 0;
  for (unsigned seed = 1; seed <= 4; ++seed) {
    std::vector<Pose2> map;
    for (double x = 0.0; x <= 30.0; x += 0.5) map.push_back({x, 0.0, 0.0});
    LostRobot beyond(corridorWithIrregularDoors(seed), map, seed);
    for (double x = 60.0; x <= 72.0; x += 0.4) EXPECT_FALSE(beyond.at({x, 0.05, 0.0})) << seed;
    LostRobot within(corridorWithIrregularDoors(seed), map, seed + 50);
    for (double x = 8.0; x <= 24.0; x += 0.4) {
      const auto found = within.at({x, 0.05, 0.0});
      if (!found) continue;
      EXPECT_NEAR(found->x, x, 0.2) << seed;
      ++right;
      break;
    }
  }
  EXPECT_GE(right, 3);
}

TEST(Relocalisation, SaysNothingInAnotherBuilding) {
  KeyframeDrive elsewhere(ringCorridor());
  KeyframeGraph keyframes;
  Relocalisation relocalisation({}, {}, {});
  KeyframeDrive map(hallWithPillars());
  std::vector<int> ids;
  for (double x = -10.0; x <= 10.0; x += 1.0) {
    keyframes.add(std::make_shared<const StoredScan>(map.at({x, 0.0, 0.0}, Pose2{}, kStep)), {x, 0.0, 0.0});
    ids.push_back(keyframes.size() - 1);
  }
  relocalisation.begin(keyframes, ids);
  const int first = keyframes.size();
  for (double s = 0.0; s < 8.0; s += 0.4) {
    const Keyframe& keyframe = elsewhere.at(onRing(s), kStep);
    keyframes.add(std::make_shared<const StoredScan>(keyframe), keyframe.T_map_base);
    const auto found = relocalisation.search(keyframes, first, keyframes.size() - 1);
    EXPECT_FALSE(found);
  }
}

}  // namespace
}  // namespace slam::test
