// SPDX-License-Identifier: BSD-3-Clause
#include "relocalisation/relocalisation.hpp"

#include <gtest/gtest.h>
#include <numeric>

#include "support/simulated/keyframes.hpp"
#include "tools/sim/world/scenes.hpp"

namespace slam::test {
namespace {

constexpr double kRight = 0.1;  // [m]
const Eigen::Vector3d kStep(0.002, 0.002, 0.0005);

/// A map of keyframes at the poses given, and a robot that drives in it without knowing where it began.
class LostRobot {
 public:
  LostRobot(const Place& place, const std::vector<Pose2>& map_poses, unsigned seed = 1)
      : LostRobot(place, map_poses, place, seed, {}) {}
  /// Drives in a place other than the one that was mapped.
  LostRobot(const Place& mapped, const std::vector<Pose2>& map_poses, const Place& place, unsigned seed,
            const RelocalisationConfig& config)
      : map_drive_(mapped, seed), drive_(place, seed + 100), relocalisation_(config, {}, {}) {
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

Place home(int number, int furniture_moved = 0) {
  const auto seed = static_cast<std::uint64_t>(number);
  return {.name = "Home",
          .low = {0.0, 0.0},
          .high = {1.0, 1.0},
          .world = sim::makeScene("homes", seed, {.furniture_moved = furniture_moved}).world};
}

/// The way through all rooms of a home, a pose each step [m].
std::vector<Pose2> homePoses(int number, double step, double length = 1e9) {
  std::vector<Pose2> poses;
  Pose2 at;
  double path = 0.0;
  for (const sim::Waypoint& waypoint : sim::makeScene("homes", static_cast<std::uint64_t>(number)).route) {
    const Eigen::Vector2d way = waypoint.pose.translation() - at.translation();
    const double heading = std::atan2(way.y(), way.x());
    for (double s = 0.0; s < way.norm() && path < length; s += step, path += step) {
      poses.push_back(Pose2{at.x, at.y, heading} * Pose2{s, 0.0, 0.0});
    }
    at = waypoint.pose;
  }
  return poses;
}

/// Where a robot that drives from the start of one home, in the map of another or its own, believes to be.
struct Belief {
  double path = 0.0;  // [m] until then
  Pose2 truth, found;
};
std::optional<Belief> believed(int driven, int mapped, int furniture_moved, const RelocalisationConfig& config = {}) {
  LostRobot robot(home(mapped), homePoses(mapped, 0.4), home(driven, furniture_moved), 1, config);
  double path = 0.0;
  for (const Pose2& truth : homePoses(driven, 0.2, 6.0)) {
    if (const auto found = robot.at(truth)) return Belief{path, truth, *found};
    path += 0.2;
  }
  return std::nullopt;
}

TEST(Relocalisation, BelievesNoPlaceInTheMapOfAnotherHome) {
  RelocalisationConfig somewhere;  // in the map, by all means
  somewhere.places.model.unchanged = -1e3;
  int fooled = 0;
  for (const auto& [driven, mapped] : {std::pair(4, 7), {5, 4}, {4, 5}, {7, 5}, {1, 4}}) {
    EXPECT_FALSE(believed(driven, mapped, 0)) << driven << " in " << mapped;
    fooled += believed(driven, mapped, 0, somewhere).has_value() ? 1 : 0;
  }
  EXPECT_GE(fooled, 3) << "were it not for the contender that it is in no place of the map";
}

TEST(Relocalisation, FindsItsOwnHomeWithTheFurnitureMoved) {
  for (const int furniture_moved : {0, 1}) {
    for (const int number : {1, 2, 5, 7}) {
      const auto found = believed(number, number, furniture_moved);
      ASSERT_TRUE(found) << number << ", moved " << furniture_moved;
      const Pose2 error = between(found->truth, found->found);
      EXPECT_LT(std::hypot(error.x, error.y), kRight) << number << ", moved " << furniture_moved;
      EXPECT_LT(found->path, furniture_moved == 0 ? 1.0 : 4.0) << number;
    }
  }
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
