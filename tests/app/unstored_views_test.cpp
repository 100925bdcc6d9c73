// SPDX-License-Identifier: BSD-3-Clause
#include "app/unstored_views.hpp"

#include <gtest/gtest.h>

namespace slam {
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

}  // namespace
}  // namespace slam
