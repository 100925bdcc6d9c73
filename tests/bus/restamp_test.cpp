// SPDX-License-Identifier: BSD-3-Clause
#include "bus/restamp.hpp"

#include <gtest/gtest.h>

#include "bus/encoding.hpp"
#include "bus/messages.hpp"
#include "bus/received.hpp"

namespace slam::restamp_test {
namespace {

template <typename Message>
void expectRestamps(Message message) {
  message.utime = 1'700'000'000'123'456;
  const auto data = test::encoded(message);
  EXPECT_EQ(utimeOf(data), message.utime);
  std::vector<std::uint8_t> room;
  const auto moved = restamped(data, message.utime - 86'400'000'000, room);
  Message back{};
  ASSERT_EQ(back.decode(moved.data(), 0, static_cast<int>(moved.size())), static_cast<int>(moved.size()));
  EXPECT_EQ(back.utime, message.utime - 86'400'000'000);
  EXPECT_EQ(test::encoded(back), std::vector<std::uint8_t>(moved.begin(), moved.end()));
}

TEST(Restamp, MovesTheStampOfAnyMessage) {
  expectRestamps(scan_t{});
  expectRestamps(wheels_t{});
  expectRestamps(imu_t{});
  expectRestamps(depth_t{});
  expectRestamps(drive_t{});
  expectRestamps(pose_estimate_t{});
  expectRestamps(odometry_t{});
  expectRestamps(health_t{});
  expectRestamps(map_tile_t{});
  expectRestamps(bot_core::pose_t{});
}

TEST(Restamp, LeavesWhatIsTooShort) {
  std::vector<std::uint8_t> room;
  const std::vector<std::uint8_t> message{1, 2, 3};
  EXPECT_EQ(utimeOf(message), 0);
  EXPECT_EQ(restamped(message, 5, room).size(), 3U);
}

}  // namespace
}  // namespace slam::restamp_test
