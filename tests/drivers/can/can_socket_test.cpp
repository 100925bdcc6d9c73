// SPDX-License-Identifier: BSD-3-Clause
// What can be tested on any kernel; the socket itself is tested in a virtual machine (tests/vm).
#include "drivers/can/can_socket.hpp"

#include <cerrno>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "runtime/clock.hpp"

namespace slam::can_socket_test {
namespace {

using namespace std::chrono_literals;
constexpr Timestamp kNow{1000s};
constexpr Duration kWall = 1'700'000'000s;

TEST(CanSocket, StampsByTheAgeOnTheWallClock) {
  EXPECT_EQ(stampFromWallClock(kWall - 3ms, kWall, kNow), kNow - 3ms);
  EXPECT_EQ(stampFromWallClock(kWall, kWall, kNow), kNow);
}

TEST(CanSocket, StampsWithTheTimeOfReadingWhenTheWallClockWasSet) {
  EXPECT_EQ(stampFromWallClock(kWall + 1ms, kWall, kNow), kNow) << "from the future";
  EXPECT_EQ(stampFromWallClock(kWall - 3600s, kWall, kNow), kNow);
  EXPECT_EQ(stampFromWallClock(Duration(0), kWall, kNow), kNow) << "no stamp at all";
}

TEST(CanSocket, ReportsThatAnInterfaceIsNotThere) {
  const auto port = makeSocketCanPort(monotonicNow);
  const std::uint32_t ids[] = {0x209};
  EXPECT_THAT(port->open("nocan77", ids), testing::AnyOf(ENODEV, EAFNOSUPPORT, EPROTONOSUPPORT));
  StampedCanFrame frame;
  EXPECT_NE(port->receive(frame), 0);
  EXPECT_NE(port->send({}), 0);
}

TEST(CanSocket, RefusesANameThatNoInterfaceCanHave) {
  const auto port = makeSocketCanPort(monotonicNow);
  EXPECT_EQ(port->open("interface-name-too-long", {}), ENAMETOOLONG);
}

}  // namespace
}  // namespace slam::can_socket_test
