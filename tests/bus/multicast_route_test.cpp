// SPDX-License-Identifier: BSD-3-Clause
#include "bus/multicast_route.hpp"

#include <gtest/gtest.h>

namespace slam {
namespace {

// That no route is noticed is Live.GoesOnWithoutMulticastRoute's, in a network of its own.

TEST(MulticastRoute, IsThereForTheLoopbacksOwnAddress) {
  EXPECT_TRUE(hasMulticastRoute("udpm://127.0.0.1:7667?ttl=0"));
}

TEST(MulticastRoute, IsNotThereForAnAddressThatNothingIsSentTo) {
  EXPECT_FALSE(hasMulticastRoute("udpm://255.255.255.255:7667")) << "broadcast, which a plain socket may not";
}

TEST(MulticastRoute, IsNoQuestionForOtherProvidersAndBadAddresses) {
  for (const char* url :
       {"memq://", "tcpq://localhost:7700", "file:///tmp/x.lcm", "udpm://robot:7667", "udpm://", ""}) {
    EXPECT_TRUE(hasMulticastRoute(url)) << url;
  }
}

}  // namespace
}  // namespace slam
