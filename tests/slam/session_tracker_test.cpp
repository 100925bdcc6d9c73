// SPDX-License-Identifier: BSD-3-Clause
#include "slam/session_tracker.hpp"

#include <gtest/gtest.h>
#include <memory>

#include "support/simulated/keyframes.hpp"

namespace slam::session_tracker_test {
namespace {

using test::onRing;

const Eigen::Vector3d kStep(0.002, 0.002, 0.0005);  // [m, m, rad]

/// A map of the ring corridor, and a session that begins in it without its place.
class Session {
 public:
  Session() {
    for (double s = 0.0; s < 40.0; s += 0.5) {
      map.keyframes.add(std::make_shared<const StoredScan>(map_drive_.at(onRing(s), Pose2{}, kStep)), onRing(s));
      map.in_map.push_back(1);
    }
  }
  /// @param T_map_given what a person said
  void begin(const Pose2& truth, KeyframeOrigin origin, const Pose2& T_map_given = {}) {
    T_given_ = T_map_given;
    start_ = truth;
    auto first = std::make_unique<Keyframe>(drive_.at(truth, kStep));
    first->id = map.keyframes.size();
    first->session = tracker.number() + 1;
    first->origin = origin;
    first->T_map_base = T_map_given;
    map.begin(*first);
    tracker.begin(*first, map, false);
  }
  SessionTracker::Finding at(const Pose2& truth, bool mapped = true) {
    const Keyframe& keyframe = drive_.at(truth, kStep);
    map.keyframes.add(std::make_shared<const StoredScan>(keyframe), T_given_ * between(start_, truth));
    map.in_map.push_back(0);
    return tracker.find(map, mapped);
  }

  KeyframeMap map;
  SessionTracker tracker{BackEndConfig{}};

 private:
  test::KeyframeDrive map_drive_{test::ringCorridor(), 1}, drive_{test::ringCorridor(), 7};
  Pose2 T_given_, start_;
};

double apart(const Pose2& a, const Pose2& b) { return (a.translation() - b.translation()).norm(); }

TEST(SessionTracker, IsPlacedFromTheBeginningInAnUnknownPlaceAlone) {
  Session session;
  EXPECT_TRUE(session.tracker.placed());
  session.tracker.load(KeyframeMap());
  EXPECT_TRUE(session.tracker.placed());
  session.map.given = session.map.keyframes.size();
  session.tracker.load(session.map);
  EXPECT_FALSE(session.tracker.placed());
  EXPECT_EQ(session.tracker.first(), session.map.given);
}

TEST(SessionTracker, FindsALostRobotInTheWholeMap) {
  Session session;
  session.begin(onRing(3.3), KeyframeOrigin::kLost);
  EXPECT_FALSE(session.tracker.placed());
  EXPECT_EQ(session.tracker.first(), 80);
  EXPECT_EQ(session.tracker.number(), 1);
  SessionTracker::Finding finding;
  double s = 3.3;
  for (; s < 10.0 && !finding.found; s += 0.4) finding = session.at(onRing(s));
  ASSERT_TRUE(finding.found);
  EXPECT_LT(apart(finding.found->T_map_newest, onRing(s - 0.4)), 0.1);
  EXPECT_FALSE(finding.refuted);
  EXPECT_FALSE(session.tracker.placed()) << "until its keyframes are";
  session.tracker.place();
  EXPECT_TRUE(session.tracker.placed());
  BackEndCounters counters;
  session.tracker.addTo(counters);
  EXPECT_EQ(counters.relocalisation.found, 1);
  EXPECT_EQ(session.tracker.newestSearch().outcome, PlaceSearch::Outcome::kFound);
}

TEST(SessionTracker, CorrectsAGivenPoseByTheMap) {
  Session session;
  session.begin(onRing(3.0), KeyframeOrigin::kGiven, onRing(3.0) * Pose2{0.3, -0.2, 0.1});
  const auto finding = session.at(onRing(3.2));
  ASSERT_TRUE(finding.found);
  EXPECT_LT(apart(finding.found->T_map_newest, onRing(3.2)), 0.05);
}

TEST(SessionTracker, AMapThatHoldsThePlaceRefutesAWrongPose) {
  Session session;
  session.begin(onRing(3.0), KeyframeOrigin::kGiven, Pose2{0.0, 0.0, 1.0});  // within the block
  EXPECT_FALSE(session.at(onRing(3.1)).refuted) << "on the second keyframe";
  const auto finding = session.at(onRing(3.2));
  EXPECT_TRUE(finding.refuted);
  EXPECT_FALSE(finding.found);
  EXPECT_FALSE(session.at(onRing(3.3)).refuted) << "it is lost already";
}

TEST(SessionTracker, WhereTheMapIsEmptyThePersonIsAccepted) {
  Session session;
  session.begin(onRing(3.0), KeyframeOrigin::kGiven, Pose2{100.0, 0.0, 1.0});
  EXPECT_FALSE(session.at(onRing(3.1), false).found);
  const auto finding = session.at(onRing(3.2), false);
  ASSERT_TRUE(finding.found);
  EXPECT_EQ(finding.found->T_map_newest, session.map.keyframes.pose(session.map.newest()));
  EXPECT_EQ(finding.found->match.observable, 3);
  EXPECT_NEAR(finding.found->match.covariance(0, 0), 0.04, 1e-9);
}

}  // namespace
}  // namespace slam::session_tracker_test
