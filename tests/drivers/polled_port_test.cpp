// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/polled_port.hpp"

#include <gtest/gtest.h>

#include "drivers/pseudo_terminal.hpp"
#include "support/wait_until.hpp"

namespace slam::polled_port_test {
namespace {

using namespace std::chrono_literals;
using test::Bytes;
using test::PseudoTerminal;

constexpr Timestamp kNow{100s};

class PolledPortTest : public testing::Test {
 protected:
  Bytes drained() {
    Bytes bytes;
    hung_up_ = !port_.drain([&](std::uint8_t byte) { bytes.push_back(byte); });
    return bytes;
  }
  PseudoTerminal line_;
  PolledPort port_{line_.path(), 115200};
  bool hung_up_ = false;
};

TEST_F(PolledPortTest, GivesWhatHasComeSinceItWasOpenedAndNeverWaits) {
  ASSERT_TRUE(port_.due(kNow));
  ASSERT_FALSE(port_.open(kNow));
  EXPECT_TRUE(drained().empty());
  const Bytes sent = {1, 2, 0, 255};
  line_.write(sent);
  EXPECT_EQ(drained(), sent);
  port_.write(Bytes{7, 8});
  EXPECT_EQ(line_.read(1s), (Bytes{7, 8}));
  EXPECT_FALSE(hung_up_);
}

TEST_F(PolledPortTest, ReportsThatThePlugWasPulledAndOpensAgainWithMoreAndMorePatience) {
  ASSERT_FALSE(port_.open(kNow));
  line_.unplug();
  drained();
  ASSERT_TRUE(hung_up_);
  port_.fail(kNow);
  EXPECT_FALSE(port_.isOpen());
  EXPECT_FALSE(port_.due(kNow + 199ms));
  ASSERT_TRUE(port_.due(kNow + 200ms));
  EXPECT_TRUE(port_.open(kNow + 200ms));
  EXPECT_FALSE(port_.due(kNow + 599ms));
  line_.plug();
  ASSERT_TRUE(port_.due(kNow + 600ms));
  EXPECT_FALSE(port_.open(kNow + 600ms));
  port_.succeeded();
  port_.fail(kNow + 2s);
  EXPECT_TRUE(port_.due(kNow + 2200ms)) << "as at first";
}

TEST_F(PolledPortTest, IsTriedAtOnceWhenItIsThereAgain) {
  line_.unplug();
  for (Timestamp now = kNow; now < kNow + 10s; now += 5ms) {
    if (!port_.due(now)) continue;
    EXPECT_TRUE(port_.open(now));
  }
  line_.plug();
  EXPECT_TRUE(port_.due(kNow + 10s + 5ms));
  line_.unplug();
  EXPECT_TRUE(port_.open(kNow + 10s + 5ms));
  EXPECT_FALSE(port_.due(kNow + 10s + 10ms));
}

TEST_F(PolledPortTest, IsOpenedAnewAtOnceAtAnotherBaudRate) {
  for (const bool in_background : {false, true}) {
    std::vector<int> opened;
    PolledPort port("x", 115200, in_background, [&](const std::string& path, int baud) {
      EXPECT_EQ(path, "x");
      opened.push_back(baud);
      return openPort(line_.path(), baud);
    });
    const auto open = [&] {
      const bool due = test::waitUntil([&] { return port.due(kNow); });
      return due && !port.open(kNow);
    };
    ASSERT_TRUE(open());
    port.reopen(9600);
    EXPECT_FALSE(port.isOpen());
    ASSERT_TRUE(open()) << "no time has passed";
    EXPECT_EQ(opened, (std::vector{115200, 9600}));
    port.fail(kNow);
    EXPECT_FALSE(port.due(kNow + 199ms));
    EXPECT_FALSE(port.due(kNow + 1ms)) << "a failure waits as before";
  }
}

TEST_F(PolledPortTest, WaitsForTheFirstBytesWhereItMay) {
  ASSERT_FALSE(port_.open(kNow));
  line_.write(Bytes{1});
  Bytes bytes;
  EXPECT_TRUE(port_.drain([&](std::uint8_t byte) { bytes.push_back(byte); }, 10s));
  EXPECT_EQ(bytes, Bytes{1});
}

TEST_F(PolledPortTest, ReportsWhatIsWrongWithADeviceInAllItsStates) {
  DeviceStatus wheels, gyro;
  DevicePort port(PortOf::kBoard, line_.path(), 115200, false, openPort, LineDevice::kBoard, {&wheels, &gyro});
  ASSERT_TRUE(port.openWhenDue(kNow));
  port.report(DeviceState::kStale, problem::kBoardSilent);
  EXPECT_TRUE(gyro.problem().is(problem::kBoardSilent));
  port.lose(kNow);
  for (const DeviceStatus* status : {&wheels, &gyro}) {
    EXPECT_EQ(status->state, DeviceState::kAbsent);
    EXPECT_TRUE(status->problem().is(problem::kPortGone));
  }
  EXPECT_FALSE(port.openWhenDue(kNow)) << "the next attempt waits";
  ASSERT_TRUE(port.openWhenDue(kNow + 1s));
  port.giveUp(kNow + 1s, problem::kBoardUnanswered);
  EXPECT_EQ(wheels.state, DeviceState::kFault);
  EXPECT_TRUE(wheels.problem().is(problem::kBoardUnanswered));
  for (Timestamp now = kNow + 1s; now < kNow + 2s; now += 100ms) {
    EXPECT_FALSE(port.openWhenDue(now)) << "it is searched for who is there instead";
  }
}

}  // namespace
}  // namespace slam::polled_port_test
