// SPDX-License-Identifier: BSD-3-Clause
#include "bus/udpm/multicast_route.hpp"

#include <gtest/gtest.h>
#include <net/if.h>

#include "support/network.hpp"

namespace slam::multicast_route_test {
namespace {

using test::OtherMachine;
using test::shell;

std::optional<int> indexOf(const char* name) { return static_cast<int>(if_nametoindex(name)); }

/// In a network namespace of its own, with the route on lo at first.
TEST(MulticastRoute, IsFollowedToEveryInterface) {
  MulticastRoute route(parseUdpmUrl("udpm://239.255.76.67:7667"));
  EXPECT_EQ(route.interface(), indexOf("lo"));
  const OtherMachine other;
  other.plug("cable", 1);
  other.plug("wlan", 2);
  other.route("cable");
  EXPECT_EQ(route.interface(), indexOf("cable"));
  other.route("wlan");
  EXPECT_EQ(route.interface(), indexOf("wlan"));
  EXPECT_EQ(route.interface(), indexOf("wlan"));
  ASSERT_TRUE(shell("ip link del wlan"));
  EXPECT_EQ(route.interface(), std::nullopt);
  EXPECT_EQ(route.interface(), std::nullopt);
  ASSERT_TRUE(shell("ip route replace 224.0.0.0/4 dev lo"));
  EXPECT_EQ(route.interface(), indexOf("lo"));
}

TEST(MulticastRoute, IsNotThereWhereItIsProhibited) {
  MulticastRoute route(parseUdpmUrl("udpm://239.255.76.67:7667"));
  EXPECT_EQ(route.interface(), indexOf("lo"));
  for (const char* kind : {"unreachable", "prohibit", "blackhole"}) {
    ASSERT_TRUE(shell(std::string("ip route add ") + kind + " 239.255.76.67"));
    EXPECT_EQ(route.interface(), std::nullopt) << kind;
    ASSERT_TRUE(shell("ip route del 239.255.76.67"));
  }
  EXPECT_EQ(route.interface(), indexOf("lo"));
}

/// Of each change that moves a route the kernel reports something, not always the route itself: that of an interface
/// which goes down disappears without a word.
TEST(MulticastRoute, MovesWithRulesAddressesAndInterfaces) {
  MulticastRoute route(parseUdpmUrl("udpm://239.255.76.67:7667"));
  EXPECT_EQ(route.interface(), indexOf("lo"));
  ASSERT_TRUE(shell("ip rule add to 239.255.76.67 unreachable"));
  EXPECT_EQ(route.interface(), std::nullopt);
  ASSERT_TRUE(shell("ip rule del to 239.255.76.67 unreachable"));
  EXPECT_EQ(route.interface(), indexOf("lo"));
  {
    const OtherMachine other;
    other.plug("cable", 1);
    other.route("cable");
    EXPECT_EQ(route.interface(), indexOf("cable"));
    ASSERT_TRUE(shell("ip link set cable down"));
    EXPECT_EQ(route.interface(), std::nullopt);
    ASSERT_TRUE(shell("ip link set cable up && ip route replace 224.0.0.0/4 dev cable"));
    EXPECT_EQ(route.interface(), indexOf("cable"));
  }
  EXPECT_EQ(route.interface(), std::nullopt);
  ASSERT_TRUE(shell("ip route replace 224.0.0.0/4 dev lo"));
  EXPECT_EQ(route.interface(), indexOf("lo"));
}

/// More reports than the socket has room for are a change, too.
TEST(MulticastRoute, IsAskedForAgainWhenReportsAreLost) {
  MulticastRoute route(parseUdpmUrl("udpm://239.255.76.67:7667"));
  EXPECT_EQ(route.interface(), indexOf("lo"));
  ASSERT_TRUE(
      shell("for i in $(seq 3000); do echo addr add 10.77.0.1/32 dev lo; echo addr del 10.77.0.1/32 dev lo; done |"
            " ip -batch - && ip route del 224.0.0.0/4 dev lo"));
  EXPECT_EQ(route.interface(), std::nullopt);
  ASSERT_TRUE(shell("ip route replace 224.0.0.0/4 dev lo"));
  for (int i = 0; i < 1000; ++i) route.interface();  // 64 reports at a time are read
  EXPECT_EQ(route.interface(), indexOf("lo"));
}

}  // namespace
}  // namespace slam::multicast_route_test
