// SPDX-License-Identifier: BSD-3-Clause
#include "frontend/depth_view_selector.hpp"

#include <gtest/gtest.h>
#include <memory>

namespace slam::depth_view_selector_test {
namespace {

using namespace std::chrono_literals;

constexpr Timestamp kBegin{100s};

class DepthViewSelection : public testing::Test {
 protected:
  bool select(Duration after, const Pose2& T_odom_base) {
    return views.select(*laser, kBegin + after, T_odom_base, 7, 2, {5, {0.1, 0.2, 0.3}}) != nullptr;
  }
  FrontEndCounters counters() const {
    FrontEndCounters counters;
    views.addTo(counters);
    return counters;
  }
  const std::unique_ptr<PseudoLaser> laser = std::make_unique<PseudoLaser>();
  DepthViewSelector views{{.translation = 0.05, .rotation = 0.05, .period = 0.2}};
};

TEST_F(DepthViewSelection, AreDrawnFromAnotherPlaceOrAfterAWhile) {
  EXPECT_TRUE(select(0ms, {})) << "the first one";
  EXPECT_FALSE(select(50ms, {0.04, 0.0, 0.04}));
  EXPECT_TRUE(select(100ms, {0.06, 0.0, 0.0}));
  EXPECT_TRUE(select(150ms, {0.06, 0.0, -0.06}));
  EXPECT_FALSE(select(340ms, {0.06, 0.0, -0.06}));
  EXPECT_TRUE(select(360ms, {0.06, 0.0, -0.06}));
  EXPECT_TRUE(select(-9s, {0.06, 0.0, -0.06})) << "the clock was set back";
  EXPECT_EQ(counters().views, 5U);
}

TEST_F(DepthViewSelection, AreCountedWhereThePoseIsNotKnown) {
  EXPECT_EQ(views.leaveOut(), nullptr);
  EXPECT_EQ(counters().views, 0U);
  EXPECT_EQ(counters().views_unplaced, 1U);
}

TEST_F(DepthViewSelection, HoldWhereTheyWereSeenFrom) {
  const DepthObservation* sight = views.select(*laser, kBegin, {}, 7, 2, {5, {0.1, 0.2, 0.3}});
  ASSERT_NE(sight, nullptr);
  EXPECT_EQ(sight->map_id, 7);
  EXPECT_EQ(sight->session, 2);
  EXPECT_EQ(sight->keyframe, 5);
  EXPECT_EQ(sight->T_keyframe_base, (Pose2{0.1, 0.2, 0.3}));
}

}  // namespace
}  // namespace slam::depth_view_selector_test
