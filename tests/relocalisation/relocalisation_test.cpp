// SPDX-License-Identifier: BSD-3-Clause
#include "relocalisation/relocalisation.hpp"

#include <cstdint>
#include <gtest/gtest.h>

#include "support/simulated/keyframes.hpp"
#include "tools/sim/world/scenes.hpp"

namespace slam::test::relocalisation_test {
namespace {

constexpr double kRight = 0.1;  // [m]
/// A robot that drives in a map made from these poses.
class LostRobot : public MappedPlace {
 public:
  LostRobot(const Place& place, const std::vector<Pose2>& map_poses, unsigned seed = 1)
      : LostRobot(place, map_poses, place, seed, {}) {}
  /// Drives in a place other than the one that was mapped.
  LostRobot(const Place& mapped, const std::vector<Pose2>& map_poses, const Place& place, unsigned seed,
            const RelocalisationConfig& config)
      : MappedPlace(mapped, map_poses, seed, place, seed + 100), relocalisation_(config, {}, {}) {
    relocalisation_.begin(keyframes, map);
  }

  /// @param scans used since the keyframe before
  /// @return the place believed, if any
  std::optional<Pose2> at(const Pose2& truth, std::int64_t scans = 1000) {
    drive(truth);
    relocalisation_.allowFor(scans);
    const auto found = relocalisation_.search(keyframes, static_cast<int>(map.size()), newest());
    return found ? std::optional(found->T_map_newest) : std::nullopt;
  }

  const Relocalisation::Counters& counters() const { return relocalisation_.counters(); }

 private:
  Relocalisation relocalisation_;
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

TEST(Relocalisation, ASearchThatMayDoLittleAtOnceFindsTheRobotLater) {
  RelocalisationConfig config;
  config.work_at_once = 200'000;
  LostRobot robot(ringCorridor(), ringPoses(), ringCorridor(), 3, config);
  std::optional<Pose2> found;
  Pose2 truth;
  for (double s = 3.3; s < 30.0 && !found; s += 0.1) found = robot.at(truth = onRing(s));
  ASSERT_TRUE(found);
  EXPECT_GT(robot.counters().interrupted, 5);
  const Pose2 error = between(truth, *found);
  EXPECT_LT(std::hypot(error.x, error.y), kRight);
  EXPECT_LT(std::abs(error.theta), 0.1);
}

TEST(Relocalisation, SearchesAsMuchAsItsScansAllow) {
  RelocalisationConfig config;
  config.work_saved = 40000;
  config.work_per_scan = 40000;  // [points], little of what a search takes
  LostRobot robot(corridorWithDoors(), alongX(-18.0, 18.0), corridorWithDoors(), 1, config);
  const auto drive = [&](int scans) {
    const Relocalisation::Counters before = robot.counters();
    for (double x = -10.0; x <= 10.0; x += 0.5) EXPECT_FALSE(robot.at({x, 0.05, 0.0}, scans));
    return robot.counters().searches - before.searches;
  };
  EXPECT_LE(drive(1), 1) << "one scan a keyframe";
  EXPECT_EQ(drive(0), 0) << "and none";
  EXPECT_GT(robot.counters().interrupted, 0);
}

TEST(Relocalisation, ReportsNothingInOneOfTwoRoomsThatAreAlike) {
  LostRobot robot(twins(), inTwins());
  for (double s = -1.0; s <= 2.0; s += 0.25) EXPECT_FALSE(robot.at({s, 0.1, 0.0}));
}

TEST(Relocalisation, ReportsNothingInAPeriodicCorridor) {
  LostRobot robot(corridorWithDoors(), alongX(-18.0, 18.0));
  for (double x = -2.0; x <= 4.0; x += 0.4) EXPECT_FALSE(robot.at({x, 0.05, 0.0}));
}

TEST(Relocalisation, DistinguishesTheDoorsOfItsOwnMapFromOthers) {
  int right = 0;
  for (unsigned seed = 1; seed <= 4; ++seed) {
    const std::vector<Pose2> map = alongX(0.0, 30.0);
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

TEST(Relocalisation, AcceptsNoPlaceInTheMapOfAnotherHome) {
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

TEST(Relocalisation, ReportsNothingInAnotherBuilding) {
  LostRobot robot(hallWithPillars(), alongX(-10.0, 10.0, 1.0), ringCorridor(), 1, {});
  for (double s = 0.0; s < 8.0; s += 0.4) EXPECT_FALSE(robot.at(onRing(s)));
}

}  // namespace
}  // namespace slam::test::relocalisation_test
