// SPDX-License-Identifier: BSD-3-Clause
#include "slam/reference_selector.hpp"

#include <gtest/gtest.h>
#include <memory>
#include <vector>

#include "support/simulated/keyframes.hpp"

namespace slam::reference_selector_test {
namespace {

constexpr std::int32_t kSession = 4;

/// Ten keyframes in a row, the first five of which the robot has lost touch with.
class ReferenceSelectorTest : public testing::Test {
 protected:
  ReferenceSelectorTest() {
    for (int id = 0; id < 10; ++id) {
      const double sigma = id == 5 ? 0.5 : 0.002;  // [m]
      map.add(drive.at({0.1 * id, 0.0, 0.0}, Pose2{}, {sigma, sigma, 1e-4}), true);
    }
  }
  std::vector<int> held() const {
    std::vector<int> ids;
    for (const ReferenceKeyframe& keyframe : map.in_reference) ids.push_back(keyframe.id);
    return ids;
  }
  static std::vector<int> heldBy(const MapCorrection& correction) {
    std::vector<int> ids;
    for (const ReferenceKeyframe& keyframe : correction.keyframes) ids.push_back(keyframe.id);
    return ids;
  }

  test::KeyframeDrive drive{test::furnishedRoom()};
  KeyframeMap map;
  ReferenceSelector selector{BackEndConfig{}};
};

TEST_F(ReferenceSelectorTest, TakesOutWhatTheRobotHasLostTouchWith) {
  selector.renew(map, 9, kSession);
  const auto correction = selector.take();
  ASSERT_TRUE(correction);
  const std::vector<int> known{5, 6, 7, 8, 9};
  EXPECT_EQ(heldBy(*correction), known);
  EXPECT_EQ(held(), known);
  EXPECT_EQ(correction->newest, 9);
  EXPECT_EQ(correction->session, kSession);
  EXPECT_GT(correction->reference.size(), 0U);
  EXPECT_EQ(selector.made(), 1);

  selector.renew(map, 9, kSession);
  EXPECT_FALSE(selector.take()) << "it is as it should be";
  selector.renew(map, 9, kSession, true);
  EXPECT_TRUE(selector.take());
}

TEST_F(ReferenceSelectorTest, TakesInWhatAClosureJoinedAndWhatItMoved) {
  selector.renew(map, 9, kSession);
  selector.take();
  const Eigen::Matrix3d sharp = Eigen::Vector3d(1e6, 1e6, 1e8).asDiagonal();
  map.keyframes.graph().addEdge({.from = 0, .to = 9, .T_from_to = {0.9, 0.0, 0.0}, .information = sharp});
  selector.renew(map, 9, kSession);
  const auto correction = selector.take();
  ASSERT_TRUE(correction);
  EXPECT_EQ(heldBy(*correction).size(), 10U);
  map.keyframes.graph().setPose(3, map.keyframes.pose(3) * Pose2{0.02, 0.0, 0.0});
  selector.renew(map, 9, kSession);
  EXPECT_TRUE(selector.take());
}

TEST_F(ReferenceSelectorTest, HoldsTheKeyframesThatItIsGiven) {
  const std::vector<int> ids{2, 4};
  selector.renew(map, {0.3, 0.0}, ids, kSession);
  selector.place({1.0, 2.0, 0.5});
  const auto correction = selector.take();
  ASSERT_TRUE(correction);
  EXPECT_EQ(heldBy(*correction), ids);
  EXPECT_EQ(held(), ids);
  EXPECT_EQ(correction->T_map_session, Pose2(1.0, 2.0, 0.5));
}

TEST_F(ReferenceSelectorTest, BuildsTheNextOneInTheMemoryOfAUsedOneFromNothing) {
  selector.refute(kSession);
  auto refuted = selector.take();
  ASSERT_TRUE(refuted);
  EXPECT_TRUE(refuted->refuted);
  EXPECT_FALSE(refuted->T_map_session);
  EXPECT_EQ(selector.made(), 0) << "it corrects nothing";
  refuted->T_map_session = Pose2{};
  const MapCorrection* memory = refuted.get();
  selector.recycle(std::move(refuted));
  selector.renew(map, 9, kSession + 1);
  const auto correction = selector.take();
  EXPECT_EQ(correction.get(), memory);
  EXPECT_FALSE(correction->refuted || correction->T_map_session);
  EXPECT_EQ(correction->session, kSession + 1);
}

}  // namespace
}  // namespace slam::reference_selector_test
