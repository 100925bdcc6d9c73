// SPDX-License-Identifier: BSD-3-Clause
#include "slam/merge/map_registration.hpp"

#include <cmath>
#include <gtest/gtest.h>
#include <numeric>

#include "support/simulated/mapped_drive.hpp"

namespace slam::map_registration_test {
namespace {

/// Two drives along a ring corridor in one graph, each in a frame of its own.
struct TwoDrives {
  TwoDrives() {
    const MapState map = test::mapped(test::ringCorridor(), test::alongRing(0.0, 30.0), 1).map;
    const test::MappedDrive drive = test::mapped(test::ringCorridor(), test::alongRing(8.0, 20.0), 2);
    keyframes = map.keyframes;
    first.resize(static_cast<std::size_t>(map.keyframes.size()));
    std::iota(first.begin(), first.end(), 0);
    for (int id = 0; id < drive.map.keyframes.size(); ++id) {
      second.push_back(keyframes.size());
      keyframes.add(drive.map.keyframes.scan(id), drive.map.keyframes.pose(id));
    }
  }
  KeyframeGraph keyframes;
  std::vector<int> first, second;
  const Pose2 T_first_second = between(test::onRing(0.0), test::onRing(8.0));
};

TEST(MapRegistration, DividesAPathIntoStretchesThatShareNothing) {
  const TwoDrives drives;
  const MapRegistration registration(drives.keyframes, drives.first, drives.second, {.stretch = 3.0});
  const auto& stretches = registration.stretches();
  ASSERT_EQ(stretches.size(), 4u);
  EXPECT_EQ(stretches.front().oldest, drives.second.front());
  EXPECT_EQ(stretches.back().newest, drives.second.back());
  for (std::size_t i = 1; i < stretches.size(); ++i) {
    EXPECT_EQ(stretches[i].oldest, stretches[i - 1].newest + 1);
    EXPECT_EQ(stretches[i].run, drives.second.front());
  }
}

TEST(MapRegistration, FindsADriveInAMapOfTheSameRooms) {
  const TwoDrives drives;
  const RegisteredMap result = MapRegistration(drives.keyframes, drives.first, drives.second).find();
  ASSERT_EQ(result.outcome, RegisteredMap::Outcome::kFound);
  const Pose2 error = between(drives.T_first_second, result.T_map_second);
  EXPECT_LT(std::hypot(error.x, error.y), 0.2);
  EXPECT_GT(result.agreement, 0.8);
  EXPECT_EQ(result.elsewhere, 0);
}

TEST(MapRegistration, AgreementFallsBesideTheTruePlace) {
  const TwoDrives drives;
  const MapRegistration registration(drives.keyframes, drives.first, drives.second);
  const Stretch& stretch = registration.stretches()[2];
  const Pose2 right = drives.T_first_second * drives.keyframes.pose(stretch.newest);
  const PlaceAgreement there = registration.agreement(stretch, right),
                       beside = registration.agreement(stretch, right * Pose2{1.5, 0.0, 0.5});
  EXPECT_GT(there.share(), 0.9);
  EXPECT_GT(there.log_likelihood, beside.log_likelihood + 16.0);
  EXPECT_LT(beside.share(), there.share());
}

TEST(MapRegistration, FindsNothingOfADriveElsewhere) {
  TwoDrives drives;
  const MapState elsewhere = test::mapped(test::furnishedRoom(), test::alongX(-1.0, 1.0, 0.25), 3).map;
  std::vector<int> second;
  for (int id = 0; id < elsewhere.keyframes.size(); ++id) {
    second.push_back(drives.keyframes.size());
    drives.keyframes.add(elsewhere.keyframes.scan(id), elsewhere.keyframes.pose(id));
  }
  const RegisteredMap result = MapRegistration(drives.keyframes, drives.first, second).find();
  EXPECT_NE(result.outcome, RegisteredMap::Outcome::kFound);
}

}  // namespace
}  // namespace slam::map_registration_test
