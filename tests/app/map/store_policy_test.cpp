// SPDX-License-Identifier: BSD-3-Clause
#include "app/map/store_policy.hpp"

#include <gtest/gtest.h>

namespace slam::store_policy_test {
namespace {

/// Views of keyframes 0, 1, ..., one each.
UnstoredViews viewsOf(int keyframes) {
  UnstoredViews views;
  for (int id = 0; id < keyframes; ++id)
    views.add({.keyframe = id, .T_map_keyframe = {}, .T_keyframe_base = {}, .view = {}});
  return views;
}

TEST(UnstoredViews, AreWrittenOnceIntoTheJournalAndAgainIntoNoCheckpointBehind) {
  UnstoredViews views = viewsOf(5);
  EXPECT_EQ(views.unjournalled()->size(), 5U);
  views.setJournalled(3);
  ASSERT_EQ(views.unjournalled()->size(), 2U);
  EXPECT_EQ(views.unjournalled()->front().keyframe, 3);
  views.setCheckpointed(4);
  ASSERT_EQ(views.size(), 1U);
  ASSERT_EQ(views.unjournalled()->size(), 1U) << "the journal begins anew";
  EXPECT_EQ(views.unjournalled()->front().keyframe, 4);
  EXPECT_EQ(views.added(), 5);
}

TEST(UnstoredViews, AreAFewOfEachKeyframe) {
  UnstoredViews views = viewsOf(2);
  for (int i = 0; i < 100; ++i) views.add({.keyframe = 1, .T_map_keyframe = {}, .T_keyframe_base = {}, .view = {}});
  const auto most = static_cast<std::size_t>(ViewMemoryConfig{}.per_keyframe);
  EXPECT_EQ(views.size(), 1 + most);
  views.setCheckpointed(views.size());
  views.add({.keyframe = 1, .T_map_keyframe = {}, .T_keyframe_base = {}, .view = {}});
  EXPECT_EQ(views.size(), 0U) << "a checkpoint does not make room for more of a known place";
  views.clear();
  views.add({.keyframe = 1, .T_map_keyframe = {}, .T_keyframe_base = {}, .view = {}});
  EXPECT_EQ(views.size(), 1U);
  EXPECT_EQ(views.added(), 1);
}

using namespace std::chrono_literals;
using Due = StorePolicy::Due;

TEST(StorePolicy, WritesACheckpointAtOnceAndThenByItsPeriod) {
  const StoreConfig config{.journal_period = 1e9, .checkpoint_period = 60.0};
  StorePolicy policy(config);
  EXPECT_EQ(policy.due(Timestamp(100s), 1, {}, false), Due::kCheckpoint) << "there is no journal before it";
  policy.endAttempt(Due::kCheckpoint, {.changes = 1}, Timestamp(100s), true);
  EXPECT_EQ(policy.due(Timestamp(500s), 1, {}, true), Due::kNothing) << "nothing changed";
  EXPECT_EQ(policy.due(Timestamp(159s), 2, {}, true), Due::kNothing);
  EXPECT_EQ(policy.due(Timestamp(160s), 2, {}, true), Due::kCheckpoint);
  policy.endAttempt(Due::kCheckpoint, {.changes = 2}, Timestamp(160s), false);
  EXPECT_EQ(policy.due(Timestamp(219s), 2, {}, true), Due::kNothing) << "the journal of the one before goes on";
  EXPECT_EQ(policy.due(Timestamp(220s), 2, {}, true), Due::kCheckpoint);
  EXPECT_EQ(policy.due(Timestamp(161s), 2, {}, false), Due::kCheckpoint);
}

TEST(StorePolicy, WritesTheJournalWhenSomethingChangedOrTheRobotMoved) {
  const StoreConfig config{.journal_period = 2.0, .checkpoint_period = 1e9};
  StorePolicy policy(config);
  const Pose2 pose{3.0, 1.0, 0.5};
  policy.endAttempt(Due::kCheckpoint, {.changes = 1, .T_map_base = pose}, Timestamp(100s), true);
  EXPECT_EQ(policy.due(Timestamp(200s), 1, pose * Pose2{0.05, 0.0, 0.05}, true), Due::kNothing);
  EXPECT_EQ(policy.due(Timestamp(200s), 1, pose * Pose2{0.11, 0.0, 0.0}, true), Due::kJournal);
  EXPECT_EQ(policy.due(Timestamp(200s), 1, pose * Pose2{0.0, 0.0, -0.11}, true), Due::kJournal);
  EXPECT_EQ(policy.due(Timestamp(200s), 2, pose, true), Due::kJournal);
  policy.endAttempt(Due::kJournal, {.changes = 2, .T_map_base = pose}, Timestamp(200s), true);
  EXPECT_EQ(policy.due(Timestamp(300s), 2, pose, true), Due::kNothing);
  EXPECT_EQ(policy.due(Timestamp(201s), 3, pose, true), Due::kNothing);
  EXPECT_EQ(policy.due(Timestamp(202s), 3, pose, true), Due::kJournal);
}

TEST(StorePolicy, RequiresACheckpointUntilOneIsWritten) {
  const StoreConfig config{.journal_period = 2.0, .checkpoint_period = 1e9};
  StorePolicy policy(config);
  policy.requireCheckpoint();
  EXPECT_FALSE(policy.requiresCheckpoint()) << "of a map that is not written";
  policy.beginMap(true);
  policy.requireCheckpoint();
  EXPECT_EQ(policy.due(Timestamp(1s), 0, {}, true), Due::kCheckpoint) << "before any period has passed";
  const StorePolicy::Extent failing = policy.beginAttempt(1, {}), stale = policy.beginAttempt(1, {});
  EXPECT_FALSE(policy.requiresCheckpoint()) << "one is under way";
  policy.cancelAttempt(stale);
  EXPECT_FALSE(policy.requiresCheckpoint()) << "it was not for that one";
  policy.endAttempt(Due::kCheckpoint, failing, Timestamp(2s), false);
  ASSERT_TRUE(policy.requiresCheckpoint());
  policy.endAttempt(Due::kCheckpoint, policy.beginAttempt(1, {}), Timestamp(3s), true);
  EXPECT_FALSE(policy.requiresCheckpoint());
}

TEST(StorePolicy, KeepsViewsOfAMapThatIsWritten) {
  const StoreConfig config;
  StorePolicy policy(config);
  policy.beginMap(false);
  policy.add({.keyframe = 1, .T_map_keyframe = {}, .T_keyframe_base = {}, .view = {}});
  EXPECT_EQ(policy.views().size(), 0U);
  policy.beginMap(true);
  for (int id = 0; id < 4; ++id) policy.add({.keyframe = id, .T_map_keyframe = {}, .T_keyframe_base = {}, .view = {}});
  const StorePolicy::Extent three{.views = 3};
  policy.endAttempt(Due::kJournal, three, Timestamp(1s), false);
  EXPECT_EQ(policy.views().unjournalled()->size(), 4U);
  policy.endAttempt(Due::kJournal, three, Timestamp(2s), true);
  EXPECT_EQ(policy.views().unjournalled()->size(), 1U);
  policy.endAttempt(Due::kCheckpoint, three, Timestamp(3s), true);
  EXPECT_EQ(policy.views().size(), 1U);
}

}  // namespace
}  // namespace slam::store_policy_test
