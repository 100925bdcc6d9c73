// SPDX-License-Identifier: BSD-3-Clause
#include "slam/map_policy.hpp"

#include <algorithm>
#include <gtest/gtest.h>
#include <memory>
#include <vector>

#include "support/simulated/keyframes.hpp"

namespace slam::map_policy_test {
namespace {

const Eigen::Vector3d kStep(0.002, 0.002, 0.0005);  // [m, m, rad]

/// A map of eight keyframes, and the policy that the mode asks for.
struct Parts {
  explicit Parts(bool localise_only, BackEndConfig with = {}) : config(std::move(with)) {
    config.localise_only = localise_only;
    policy = mapPolicy(config, map, reference);
    for (int id = 0; id < 8; ++id) map.add(drive.at({0.2 * id, 0.0, 0.0}, kStep), true);
  }
  const Keyframe& beginSession(std::int32_t number) {
    first = std::make_unique<Keyframe>(drive.at({2.0, 0.5, 0.0}, kStep));
    first->id = config.localise_only ? map.given : map.keyframes.size();
    first->session = number;
    first->origin = KeyframeOrigin::kLost;
    policy->begin(*first, session);
    return *first;
  }
  /// Begins one, which is found at once.
  void findSession(const Pose2& T_map_base) {
    beginSession(1);
    placeSession(T_map_base);
  }
  void placeSession(const Pose2& T_map_base) {
    map.keyframes.graph().setPose(map.newest(), T_map_base);
    Relocalisation::Found found{T_map_base, {}};
    found.match.T_ref_base = T_map_base;
    found.match.directions.setIdentity();
    found.match.observable = 3;
    session.place();
    policy->place(found, session);
  }
  void driveOn(const Pose2& truth) {
    Keyframe keyframe = drive.at(truth, kStep);
    keyframe.directions.setIdentity();
    keyframe.observable = 3;
    map.add(keyframe, true);
    policy->extend(keyframe);
  }
  std::vector<Pose2> poses() const {
    const auto poses = map.keyframes.graph().poses();
    return {poses.begin(), poses.end()};
  }
  BackEndCounters counters() const {
    BackEndCounters counters;
    policy->addTo(counters);
    return counters;
  }

  test::KeyframeDrive drive{test::furnishedRoom()};
  BackEndConfig config;
  KeyframeMap map;
  ReferenceSelector reference{BackEndConfig{}};
  SessionTracker session{BackEndConfig{}};
  std::unique_ptr<MapPolicy> policy;
  std::unique_ptr<Keyframe> first;
};

TEST(MapPolicy, OnlyAGrowingMapIsDrawn) {
  EXPECT_TRUE(Parts(false).policy->draws());
  EXPECT_FALSE(Parts(true).policy->draws());
}

TEST(GrowingMap, KeepsItsGraphInOnePieceByAnEdgeWithoutInformation) {
  Parts parts(false);
  parts.beginSession(1);
  ASSERT_EQ(parts.map.keyframes.size(), 9);
  const Edge& edge = parts.map.keyframes.graph().edges().back();
  EXPECT_EQ(edge.from, 7);
  EXPECT_EQ(edge.to, 8);
  EXPECT_LT(edge.information.norm(), 1e-5);
  EXPECT_FALSE(parts.session.placed());
  EXPECT_EQ(parts.session.first(), 8);
}

TEST(GrowingMap, HasMappedWhatIsNearToItsKeyframes) {
  Parts parts(false);
  EXPECT_TRUE(parts.policy->isMapped({0.0, 4.9}));
  EXPECT_FALSE(parts.policy->isMapped({0.0, 5.1}));
  for (char& known : parts.map.in_map) known = 0;
  EXPECT_FALSE(parts.policy->isMapped({0.0, 0.0}));
}

TEST(GrowingMap, TiesAFoundSessionToTheMapWhereItIs) {
  Parts parts(false);
  parts.findSession({0.6, 0.1, 0.0});
  EXPECT_FALSE(parts.map.inMap(8)) << "not yet";
  EXPECT_FALSE(parts.policy->draws());
  EXPECT_EQ(parts.map.generation, 0);
  const Edge& edge = parts.map.keyframes.graph().edges().back();
  EXPECT_EQ(edge.kind, EdgeKind::kLoopClosure);
  EXPECT_EQ(edge.from, 3) << "0.1 m away";
  EXPECT_EQ(edge.to, 8);
  const auto correction = parts.reference.take();
  ASSERT_TRUE(correction);
  EXPECT_EQ(correction->session, 1);
  EXPECT_EQ(correction->keyframes.size(), 9U);
}

TEST(GrowingMap, AFoundSessionIsAsUncertainAsTheMapWhereItWasJoined) {
  Parts parts(false);
  auto joined_at = std::make_shared<StoredScan>(*parts.map.keyframes.scan(3));
  parts.map.keyframes.graph().setPose(3, {0.6, 0.0, 0.0});
  joined_at->covariance = Eigen::Vector3d(4e-4, 1e-4, 1e-2).asDiagonal();
  parts.map.keyframes.setScan(3, std::move(joined_at));
  const Eigen::Matrix3d in_session = Eigen::Vector3d(1e-6, 2e-6, 3e-6).asDiagonal();
  parts.beginSession(1);
  auto scan = std::make_shared<StoredScan>(*parts.map.keyframes.scan(8));
  scan->covariance = in_session;
  parts.map.keyframes.setScan(8, std::move(scan));
  parts.placeSession({0.6, 0.1, 0.0});
  const Eigen::Matrix3d in_map = parts.map.keyframes.scan(8)->covariance;
  EXPECT_NEAR(in_map(0, 0), 1e-6 + 4e-4 + 0.1 * 0.1 * 1e-2, 1e-12) << "its heading moves what lies beside it";
  EXPECT_NEAR(in_map(1, 1), 2e-6 + 1e-4, 1e-12);
  EXPECT_NEAR(in_map(2, 2), 3e-6 + 1e-2, 1e-12);
  const auto correction = parts.reference.take();
  ASSERT_TRUE(correction);
  EXPECT_EQ(correction->keyframes.back().id, 8);
  EXPECT_EQ(correction->keyframes.back().covariance, in_map) << "the front end takes it over";
}

TEST(GrowingMap, ARobotLostSoonLeavesTheMapAsItWas) {
  BackEndConfig config;
  config.link_age = 2;
  Parts parts(false, config);
  const auto before = parts.poses();
  parts.findSession({0.6, 0.1, 0.0});
  for (int i = 1; i <= 8; ++i) parts.driveOn({2.0 + 0.1 * i, 0.5, 0.0});
  const auto standing = [&] {
    const auto edges = parts.map.keyframes.graph().edges();
    return std::count_if(edges.begin(), edges.end(), [](const Edge& edge) {
      return edge.from < 8 && edge.to >= 8 && !edge.revoked && edge.information.norm() > 1.0;
    });
  };
  ASSERT_GT(standing(), 1) << "the join, and matches to the map";
  parts.beginSession(2);
  EXPECT_EQ(standing(), 0);
  EXPECT_EQ(parts.counters().taken_back, 1);
  EXPECT_TRUE(parts.policy->draws()) << "the next session may";
  EXPECT_EQ(parts.map.generation, 0);
  const auto after = parts.poses();
  for (std::size_t id = 0; id < after.size(); ++id) {
    EXPECT_EQ(parts.map.inMap(static_cast<int>(id)), id < 8) << id;
  }
  EXPECT_TRUE(std::equal(before.begin(), before.end(), after.begin()));
  for (const auto& reached : parts.map.keyframes.graph().reach(0, 1.0)) EXPECT_LT(reached.node, 8);
}

TEST(GrowingMap, IsOutgrownByASessionOfMoreKeyframesUnlessItWasStored) {
  BackEndConfig config;
  config.outgrown = 0.2;  // times eight keyframes
  Parts parts(false, config);
  parts.beginSession(1);
  EXPECT_FALSE(parts.policy->outgrownBy(parts.session));
  parts.map.add(parts.drive.at({2.1, 0.5, 0.0}, kStep), false);
  EXPECT_TRUE(parts.policy->outgrownBy(parts.session));
  parts.map.given = 1;
  EXPECT_FALSE(parts.policy->outgrownBy(parts.session));
}

TEST(FixedMap, ForgetsTheSessionBefore) {
  Parts parts(true);
  parts.map.given = 8;
  for (const std::int32_t number : {1, 2}) {
    parts.beginSession(number);
    EXPECT_EQ(parts.map.keyframes.size(), 9) << number;
    EXPECT_EQ(parts.session.number(), number);
    EXPECT_EQ(parts.map.keyframes.graph().edges().size(), 7U) << "those of the map";
  }
}

TEST(FixedMap, ItsReferenceFollowsTheRobotInSteps) {
  Parts parts(true);
  parts.map.given = 8;
  parts.policy->place({{0.5, 0.0, 0.0}, {}}, parts.session);
  auto correction = parts.reference.take();
  ASSERT_TRUE(correction);
  EXPECT_EQ(correction->keyframes.size(), 8U);
  auto look = std::make_unique<Keyframe>(parts.drive.refresh({0.5, 0.0, 0.0}, 2));
  for (const double x : {8.4, 8.6}) {
    look->T_map_base = {x, 0.0, 0.0};
    parts.policy->follow(*look);
    EXPECT_EQ(parts.reference.take() != nullptr, x > 8.5) << x;
  }
  look->T_map_base = {40.0, 0.0, 0.0};  // beyond all keyframes
  parts.policy->follow(*look);
  correction = parts.reference.take();
  ASSERT_TRUE(correction);
  EXPECT_TRUE(correction->keyframes.empty());
}

}  // namespace
}  // namespace slam::map_policy_test
