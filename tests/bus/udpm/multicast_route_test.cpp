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
  const MulticastRoute route(parseUdpmUrl("udpm://239.255.76.67:7667"));
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
  const MulticastRoute route(parseUdpmUrl("udpm://239.255.76.67:7667"));
  for (const char* kind : {"unreachable", "prohibit", "blackhole"}) {
    ASSERT_TRUE(shell(std::string("ip route add ") + kind + " 239.255.76.67"));
    EXPECT_EQ(route.interface(), std::nullopt) << kind;
    ASSERT_TRUE(shell("ip route del 239.255.76.67"));
  }
  EXPECT_EQ(route.interface(), indexOf("lo"));
}

}  // namespace
}  // namespace slam::multicast_route_test
