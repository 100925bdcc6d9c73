// SPDX-License-Identifier: BSD-3-Clause
#include "tools/sim/faults/line_faults.hpp"

#include <gmock/gmock.h>

namespace slam::sim::line_faults_test {
namespace {

using namespace std::chrono_literals;
using testing::ElementsAre;
using testing::IsEmpty;

constexpr Timestamp kNow{100s};

TEST(LineFaults, PassesWhatIsSentWhileNothingIsWrong) {
  EXPECT_THAT(LineFaults().pass({1, 2, 3}, kNow), ElementsAre(1, 2, 3));
}

TEST(LineFaults, HasItsKindsAndNoOthers) {
  LineFaults faults;
  EXPECT_TRUE(faults.inject("unplug", 1));
  EXPECT_TRUE(faults.unplugged());
  EXPECT_TRUE(faults.inject("unplug", 0));
  EXPECT_FALSE(faults.unplugged());
  EXPECT_FALSE(faults.inject("unplug", 2));
  EXPECT_FALSE(faults.inject("delay", -1));
  EXPECT_FALSE(faults.inject("delay", 1e9));
  EXPECT_FALSE(faults.inject("delay", std::numeric_limits<double>::quiet_NaN()));
  EXPECT_FALSE(faults.inject("silent", 1)) << "that is the device's";
}

TEST(LineFaults, GarbageHasTheLengthOfWhatWasSent) {
  LineFaults faults;
  ASSERT_TRUE(faults.inject("garbage", 1));
  const std::vector<std::uint8_t> sent(200, 7);
  const auto arrived = faults.pass(sent, kNow);
  EXPECT_EQ(arrived.size(), sent.size());
  EXPECT_NE(arrived, sent);
  ASSERT_TRUE(faults.inject("garbage", 0));
  EXPECT_EQ(faults.pass(sent, kNow), sent);
}

TEST(LineFaults, DelayKeepsTheOrderAndLosesNothing) {
  LineFaults faults;
  ASSERT_TRUE(faults.inject("delay", 50));
  EXPECT_THAT(faults.pass({1}, kNow), IsEmpty());
  EXPECT_THAT(faults.pass({2}, kNow + 20ms), IsEmpty());
  EXPECT_THAT(faults.pass({}, kNow + 50ms), ElementsAre(1));
  ASSERT_TRUE(faults.inject("delay", 0));
  EXPECT_THAT(faults.pass({3}, kNow + 55ms), ElementsAre(2, 3)) << "what was held back comes first";
  EXPECT_THAT(faults.pass({4}, kNow + 56ms), ElementsAre(4));
}

}  // namespace
}  // namespace slam::sim::line_faults_test
