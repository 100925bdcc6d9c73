// SPDX-License-Identifier: BSD-3-Clause
#include "tools/sim/depth/depth_faults.hpp"

#include <cstring>
#include <gtest/gtest.h>

#include "tools/sim/depth/depth_wire.hpp"

namespace slam::sim::depth_faults_test {
namespace {

constexpr std::size_t kPixels = 64;

std::vector<std::uint8_t> frame(std::uint16_t depth, std::uint32_t index = 1) {
  DepthFrameHeader header{.width = 8, .height = 8, .frame = index, .size = 2 * kPixels};
  std::vector<std::uint8_t> bytes(sizeof header + header.size);
  std::memcpy(bytes.data(), &header, sizeof header);
  for (std::size_t i = 0; i < kPixels; ++i) std::memcpy(&bytes[sizeof header + 2 * i], &depth, 2);
  return bytes;
}

TEST(DepthFaults, LeaveASoundFrameAlone) {
  DepthFaults faults;
  auto sent = frame(2000);
  EXPECT_TRUE(faults.spoil(sent));
  EXPECT_EQ(sent, frame(2000));
}

TEST(DepthFaults, StuckShowsTheFirstPictureWithNewStamps) {
  DepthFaults faults;
  ASSERT_TRUE(faults.inject("stuck", 1));
  auto first = frame(2000, 1), second = frame(3000, 2);
  ASSERT_TRUE(faults.spoil(first));
  ASSERT_TRUE(faults.spoil(second));
  EXPECT_EQ(second, frame(2000, 2));
  ASSERT_TRUE(faults.inject("stuck", 0));
  auto third = frame(4000, 3);
  ASSERT_TRUE(faults.spoil(third));
  EXPECT_EQ(third, frame(4000, 3));
}

TEST(DepthFaults, FreezeAndSlowKeepFramesBack) {
  DepthFaults faults;
  ASSERT_TRUE(faults.inject("freeze", 1));
  auto sent = frame(2000);
  EXPECT_FALSE(faults.spoil(sent));
  ASSERT_TRUE(faults.inject("freeze", 0));
  ASSERT_TRUE(faults.inject("slow", 5));
  int passed = 0;
  for (int i = 0; i < 100; ++i) passed += faults.spoil(sent);
  EXPECT_EQ(passed, 20);
}

TEST(DepthFaults, WrongScalesDepthsWithoutOverflow) {
  DepthFaults faults;
  ASSERT_TRUE(faults.inject("wrong", 1.5));
  auto near = frame(2000), far = frame(60000);
  ASSERT_TRUE(faults.spoil(near));
  EXPECT_EQ(near, frame(3000));
  ASSERT_TRUE(faults.spoil(far));
  EXPECT_EQ(far, frame(65535));
}

TEST(DepthFaults, GarbageKeepsTheHeader) {
  DepthFaults faults;
  ASSERT_TRUE(faults.inject("garbage", 1));
  auto sent = frame(2000);
  ASSERT_TRUE(faults.spoil(sent));
  EXPECT_TRUE(std::equal(sent.begin(), sent.begin() + sizeof(DepthFrameHeader), frame(2000).begin()));
  EXPECT_NE(sent, frame(2000));
}

TEST(DepthFaults, RefuseOthers) {
  DepthFaults faults;
  EXPECT_FALSE(faults.inject("health", 1));
  EXPECT_FALSE(faults.inject("slow", 0));
  EXPECT_FALSE(faults.inject("wrong", -1));
  EXPECT_FALSE(faults.inject("unplug", 0.5));
}

}  // namespace
}  // namespace slam::sim::depth_faults_test
