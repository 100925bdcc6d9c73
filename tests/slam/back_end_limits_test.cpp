// SPDX-License-Identifier: BSD-3-Clause
// Which keyframes the back end joins, and when it renews the front end's reference.
#include <Eigen/LU>
#include <cmath>
#include <gtest/gtest.h>
#include <memory>
#include <tuple>
#include <utility>

#include "slam/back_end.hpp"
#include "support/simulated/keyframes.hpp"

namespace slam::back_end_limits_test {
namespace {

const Eigen::Vector3d kSharp(0.004, 0.004, 0.001);  // [m, m, rad]
const Pose2 kPlace{-1.4, -0.8, 0.3};

struct Session {
  explicit Session(const BackEndConfig& config = {})
      : drive(test::furnishedRoom()), back_end(std::make_unique<BackEnd>(config)) {}
  void add(const Pose2& truth, const Pose2& error = {}, const Eigen::Vector3d& sigma = kSharp) {
    back_end->add(drive.at(truth, error, sigma));
    if (auto next = back_end->takeCorrection()) correction = std::move(next);
  }
  std::size_t edges() const { return back_end->keyframes().graph().edges().size(); }

  test::KeyframeDrive drive;
  std::unique_ptr<BackEnd> back_end;
  std::unique_ptr<MapCorrection> correction;  // the newest
};

TEST(BackEndLimits, AClosureThatOnlyTurnsKeyframesRenewsTheReference) {
  // The robot turns on the spot, and the wheels tell one turn wrongly: the closure moves nothing but headings.
  for (const double error : {0.06, -0.06}) {
    Session session;
    for (int i = 0; i < 8; ++i) session.add(kPlace * Pose2{0, 0, 0.2 * i});
    EXPECT_EQ(session.correction, nullptr) << "the front end has built all that itself";
    session.add(kPlace * Pose2{0, 0, 1.6}, {0, 0, error}, {0.06, 0.06, 0.03});
    ASSERT_GT(session.back_end->counters().loop_closures, 0);
    for (int id = 0; id < 9; ++id) {
      const Pose2 moved =
          between(session.drive.measured[static_cast<std::size_t>(id)], session.back_end->keyframes().pose(id));
      ASSERT_LT(std::hypot(moved.x, moved.y), 0.01) << "no keyframe has moved";
    }
    ASSERT_NE(session.correction, nullptr);
    const ReferenceKeyframe& newest = session.correction->keyframes.back();
    ASSERT_EQ(newest.id, 8);
    const Pose2 step = between(session.correction->keyframes.front().T_map_base, newest.T_map_base);
    EXPECT_NEAR(wrapAngle(step.theta - session.drive.trueRelative(0, 8).theta), 0.0, 0.01);
  }
}

TEST(BackEndLimits, JoinsOnlyKeyframesThatAreSoManyOlder) {
  for (const int age : {10, 4}) {
    BackEndConfig config;
    config.link_age = age;
    Session session(config);
    for (int id = 0; id < 14; ++id) {
      const std::size_t before = session.edges();
      session.add(kPlace * Pose2{0.02 * id, 0, 0});
      EXPECT_EQ(session.edges() - before, id == 0 ? 0U : id < age ? 1U : 2U) << id;
      if (id >= age) {
        EXPECT_LE(session.back_end->keyframes().graph().edges().back().from, id - age);
      }
    }
  }
}

TEST(BackEndLimits, JoinsOnlyKeyframesThatSawTheSame) {
  struct Case {
    Pose2 step;
    double distance;
    bool joined;
  };
  for (const Case& c :
       {Case{{0.95, 0, 0}, 1.0, true}, Case{{0, 1.05, 0}, 1.0, false}, Case{{0.55, 0, 0}, 0.5, false},
        Case{{0.5, 0, 1.4}, 1.0, true}, Case{{0.5, 0, 1.8}, 1.0, false}, Case{{0.5, 0, -1.8}, 1.0, false}}) {
    BackEndConfig config;
    config.link_age = 1;
    config.link_distance = c.distance;
    Session session(config);
    session.add(kPlace);
    session.add(kPlace * c.step);
    EXPECT_EQ(session.edges(), c.joined ? 2U : 1U) << c.step.x << " " << c.step.y << " " << c.step.theta;
  }
}

TEST(BackEndLimits, AJoinIsAsSharpAsItsSigmas) {
  BackEndConfig config;
  config.link_age = 1;
  config.link_translation_sigma = 0.04;
  config.link_rotation_sigma = 0.02;
  Session session(config);
  session.add(kPlace);
  session.add(kPlace * Pose2{0.3, 0.1, 0.7});
  ASSERT_EQ(session.edges(), 2U);
  const Edge& edge = session.back_end->keyframes().graph().edges().back();
  const Eigen::Vector3d expected(1 / (0.04 * 0.04), 1 / (0.04 * 0.04), 1 / (0.02 * 0.02));
  EXPECT_LT((edge.information - Eigen::Matrix3d(expected.asDiagonal())).norm(), 1e-6 * expected.norm());
  EXPECT_EQ(edge.kind, EdgeKind::kMotion);
}

TEST(BackEndLimits, ARenewedReferenceTakesWhatIsKnownToTwiceTheActiveSigma) {
  for (const auto& [sigma, taken] : {std::pair(0.09, true), std::pair(0.115, false)}) {
    BackEndConfig config;
    config.closure.min_overlap = 1.1;  // no loop is closed
    Session session(config);
    for (int id = 0; id < 6; ++id) {  // the first three are lost touch with, and nobody may correct that yet
      const Eigen::Vector3d step = id == 3 ? Eigen::Vector3d(0.3, 0.3, 1e-4) : kSharp;
      session.back_end->add(session.drive.at(kPlace * Pose2{0.05 * id, 0, 0}, {}, step), false);
    }
    session.add(kPlace * Pose2{0.3, 0, 0}, {}, {sigma, sigma, 1e-4});
    ASSERT_NE(session.correction, nullptr);
    EXPECT_EQ(session.correction->keyframes.front().id, taken ? 3 : 6) << sigma;
  }
}

TEST(BackEndLimits, OnlyAMapOfFewKeyframesIsForgotten) {
  for (const auto& [few, outgrown, anew] : {std::tuple(3, 4.0, 1), std::tuple(2, 4.0, 0), std::tuple(3, 6.0, 0)}) {
    BackEndConfig config;
    config.few_keyframes = few;
    config.outgrown = outgrown;
    Session session(config);
    for (int id = 0; id < 3; ++id) session.add(kPlace * Pose2{0.05 * id, 0, 0});
    session.drive.place = test::hallWithPillars();
    for (int i = 0; i < 14; ++i) {
      auto keyframe = std::make_unique<Keyframe>(session.drive.at({6.0, 1.0, 0.0}, {}, kSharp));
      keyframe->session = 1;
      keyframe->origin = i == 0 ? KeyframeOrigin::kLost : KeyframeOrigin::kContinued;
      session.back_end->add(*keyframe);
      session.back_end->takeCorrection();
    }
    EXPECT_EQ(session.back_end->counters().begun_anew, anew) << few << " " << outgrown;
  }
}

}  // namespace
}  // namespace slam::back_end_limits_test
