// SPDX-License-Identifier: BSD-3-Clause
#include "slam/map_policy.hpp"

#include <gtest/gtest.h>
#include <memory>

#include "support/simulated/keyframes.hpp"

namespace slam {
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

TEST(GrowingMap, KeepsItsGraphInOnePieceByAnEdgeThatKnowsNothing) {
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

TEST(GrowingMap, KnowsWhatIsNearToItsKeyframes) {
  Parts parts(false);
  EXPECT_TRUE(parts.policy->knows({0.0, 4.9}));
  EXPECT_FALSE(parts.policy->knows({0.0, 5.1}));
  for (char& known : parts.map.in_map) known = 0;
  EXPECT_FALSE(parts.policy->knows({0.0, 0.0}));
}

TEST(GrowingMap, TakesAFoundSessionInAndJoinsItWhereItIs) {
  Parts parts(false);
  parts.beginSession(1);
  parts.map.keyframes.graph().setPose(8, {0.6, 0.1, 0.0});
  Relocalisation::Found found{parts.map.keyframes.pose(8), {}};
  found.match.T_ref_base = found.T_map_newest;
  found.match.observable = 3;
  parts.policy->place(found, parts.session);
  EXPECT_TRUE(parts.map.inMap(8));
  EXPECT_EQ(parts.map.generation, 1);
  const Edge& edge = parts.map.keyframes.graph().edges().back();
  EXPECT_EQ(edge.kind, EdgeKind::kLoopClosure);
  EXPECT_EQ(edge.from, 3) << "0.1 m away";
  EXPECT_EQ(edge.to, 8);
  const auto correction = parts.reference.take();
  ASSERT_TRUE(correction);
  EXPECT_EQ(correction->session, 1);
  EXPECT_EQ(correction->keyframes.size(), 9U);
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
}  // namespace slam
