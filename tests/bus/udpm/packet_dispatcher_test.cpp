// SPDX-License-Identifier: BSD-3-Clause
#include "bus/udpm/packet_dispatcher.hpp"

#include <gtest/gtest.h>
#include <vector>

#include "bus/packets.hpp"

namespace slam::packet_dispatcher_test {
namespace {

using test::deadlyFragment;
using test::packetOf;
using Bytes = std::vector<std::uint8_t>;

TEST(PacketDispatcher, HandsAMessageToItsChannelAlone) {
  PacketDispatcher dispatcher;
  std::vector<Bytes> scans, commands;
  dispatcher.subscribe("SLAM_SCAN", [&](auto data) { scans.emplace_back(data.begin(), data.end()); });
  dispatcher.subscribe("SLAM_COMMAND", [&](auto data) { commands.emplace_back(data.begin(), data.end()); });
  dispatcher.take(packetOf("SLAM_SCAN", Bytes{1, 2, 3}));
  dispatcher.take(packetOf("SLAM_SCAN_2", Bytes{4}));
  dispatcher.take(packetOf("SLAM", Bytes{5}));
  dispatcher.take(packetOf("SLAM_SCAN", Bytes{}));
  EXPECT_EQ(scans, (std::vector<Bytes>{{1, 2, 3}, {}}));
  EXPECT_TRUE(commands.empty());
  EXPECT_EQ(dispatcher.counts().messages, 4U);
}

TEST(PacketDispatcher, CountsWhatItDropsAndGoesOn) {
  PacketDispatcher dispatcher;
  int taken = 0;
  dispatcher.subscribe("SLAM_COMMAND", [&](auto) { ++taken; });
  dispatcher.take(Bytes{});
  dispatcher.take(Bytes(2000, 0xFF));
  dispatcher.take(deadlyFragment("CAMERA"));
  EXPECT_TRUE(dispatcher.tooLarge().empty()) << "what other programs send each other";
  dispatcher.take(deadlyFragment("SLAM_COMMAND"));
  dispatcher.take(packetOf("SLAM_COMMAND", Bytes{1}));
  EXPECT_EQ(dispatcher.counts().others, 2U);
  EXPECT_EQ(dispatcher.counts().fragments, 2U);
  EXPECT_EQ(dispatcher.tooLarge(), "SLAM_COMMAND");
  EXPECT_EQ(taken, 1);
}

TEST(PacketDispatcher, PutsTogetherWhatMayBeLarge) {
  PacketDispatcher dispatcher;
  std::vector<std::size_t> scans;
  int commands = 0;
  dispatcher.subscribe(
      "SLAM_SCAN", [&](auto data) { scans.push_back(data.size()); }, /*may_be_large=*/true);
  dispatcher.subscribe("SLAM_COMMAND", [&](auto) { ++commands; });
  for (const char* channel : {"SLAM_SCAN", "SLAM_COMMAND"}) {
    dispatcher.take(test::fragmentOf({100'000, 0, 0, 2}, channel, 60'000));
    dispatcher.take(test::fragmentOf({100'000, 60'000, 1, 2}, "", 40'000));
  }
  EXPECT_EQ(scans, std::vector<std::size_t>{100'000});
  EXPECT_EQ(commands, 0);
  EXPECT_EQ(dispatcher.tooLarge(), "SLAM_COMMAND");
}

}  // namespace
}  // namespace slam::packet_dispatcher_test
