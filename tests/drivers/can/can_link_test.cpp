// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/can/can_link.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "drivers/can/fake_can_port.hpp"
#include "support/allocations.hpp"

namespace slam::can_link_test {
namespace {

using namespace std::chrono_literals;
using testing::ElementsAre;

constexpr can::Frame kData{.id = 0x209, .size = 8};
constexpr can::Frame kSetPoint{.id = 0x20D, .size = 8, .data = {1}};
constexpr std::uint32_t kController = 0x4, kBusOff = 0x40, kRestarted = 0x100;  // classes of error frames
constexpr std::uint8_t kWarning = 0x08, kPassive = 0x20, kActive = 0x40, kOverflow = 0x01;

class CanLinkTest : public testing::Test {
 protected:
  void tickFor(Duration time) {
    for (const Timestamp end = bus_.clock + time; bus_.clock < end;) {
      bus_.clock += 5ms;
      tick();
    }
  }
  void tick() {
    link_.tick(bus_.clock);
    StampedCanFrame frame;
    while (link_.receive(frame)) received_.push_back(frame.frame);
  }
  void up() {
    tick();
    ASSERT_EQ(link_.state(), CanLinkState::kUp);
  }

  test::FakeCanBus bus_;
  CanLink link_{std::make_unique<test::FakeCanPort>(bus_), "can0", {0x209, 0x309}};
  std::vector<can::Frame> received_;
};

TEST_F(CanLinkTest, ReceivesTheIdsItAskedFor) {
  up();
  EXPECT_EQ(bus_.interface, "can0");
  EXPECT_THAT(bus_.ids, ElementsAre(0x209, 0x309));
  bus_.put(kData);
  bus_.put({.id = 0x123, .size = 1});
  tick();
  EXPECT_THAT(received_, ElementsAre(kData));
  EXPECT_EQ(link_.counters().received, 1U);
}

TEST_F(CanLinkTest, AsksForAMissingInterfaceAtLeastEverySecondAndNotOften) {
  bus_.open_error = ENODEV;
  tickFor(10s);
  EXPECT_EQ(link_.state(), CanLinkState::kGone);
  EXPECT_GE(bus_.opens, 10);
  EXPECT_LE(bus_.opens, 16);
  bus_.open_error = 0;
  tickFor(1s);
  EXPECT_EQ(link_.state(), CanLinkState::kUp);
}

TEST_F(CanLinkTest, DistinguishesAKernelWithoutCanFromAMissingInterface) {
  bus_.open_error = EAFNOSUPPORT;
  tick();
  EXPECT_EQ(link_.state(), CanLinkState::kUnsupported);
  bus_.open_error = EPERM;
  tickFor(1s);
  EXPECT_EQ(link_.state(), CanLinkState::kRefused);
}

TEST_F(CanLinkTest, UsesTheSameSocketAfterDownAndUp) {
  up();
  bus_.pending_error = bus_.interface_error = ENETDOWN;
  tick();
  EXPECT_EQ(link_.state(), CanLinkState::kDown);
  tickFor(1s);
  EXPECT_EQ(link_.state(), CanLinkState::kDown);
  bus_.interface_error = 0;
  tickFor(200ms);
  EXPECT_EQ(link_.state(), CanLinkState::kUp);
  EXPECT_EQ(bus_.opens, 1);
}

TEST_F(CanLinkTest, SeesAnInterfaceThatIsDownFromTheStart) {
  bus_.interface_error = ENETDOWN;
  tick();
  EXPECT_EQ(link_.state(), CanLinkState::kDown);
}

TEST_F(CanLinkTest, BindsAnewWhenTheInterfaceWasRemovedAndIsBack) {
  up();
  bus_.pending_error = ENODEV;
  bus_.open_error = ENODEV;
  tick();
  EXPECT_EQ(link_.state(), CanLinkState::kGone);
  EXPECT_FALSE(bus_.open);
  tickFor(5s);
  bus_.open_error = 0;
  tickFor(1s + 5ms);
  EXPECT_EQ(link_.state(), CanLinkState::kUp);
  EXPECT_EQ(link_.counters().opened, 2U);
  bus_.put(kData);
  tick();
  EXPECT_EQ(received_.size(), 1U);
}

TEST_F(CanLinkTest, NoticesAnInterfaceThatWasExchangedWithoutAWord) {
  up();
  bus_.interface_error = ENODEV;  // another one has its name
  tickFor(100ms);
  bus_.interface_error = 0;
  tickFor(200ms);
  EXPECT_EQ(link_.counters().opened, 2U);
  EXPECT_EQ(link_.state(), CanLinkState::kUp);
}

TEST_F(CanLinkTest, IsBusOffUntilTheControllerIsRestarted) {
  up();
  bus_.putError(kBusOff);
  tickFor(1s);
  EXPECT_EQ(link_.state(), CanLinkState::kBusOff);
  bus_.putError(kRestarted);
  tick();
  EXPECT_EQ(link_.state(), CanLinkState::kUp);
  EXPECT_EQ(link_.counters().bus_offs, 1U);
  EXPECT_EQ(link_.counters().restarts, 1U);
  EXPECT_TRUE(received_.empty()) << "error frames are no data";
}

TEST_F(CanLinkTest, IsOnTheBusAgainWhenFramesCome) {
  up();
  bus_.putError(kBusOff);
  tick();
  bus_.put(kData);
  tick();
  EXPECT_EQ(link_.state(), CanLinkState::kUp);
}

TEST_F(CanLinkTest, IsErrorPassiveUntilTheControllerIsActiveAgain) {
  up();
  bus_.putError(kController, kWarning);
  tick();
  EXPECT_EQ(link_.state(), CanLinkState::kUp);
  bus_.putError(kController, kPassive);
  tick();
  EXPECT_EQ(link_.state(), CanLinkState::kErrorPassive);
  EXPECT_TRUE(link_.usable());
  bus_.putError(kController, kActive);
  tick();
  EXPECT_EQ(link_.state(), CanLinkState::kUp);
  bus_.putError(kController, kOverflow);
  tick();
  EXPECT_EQ(link_.counters().overflows, 1U);
}

TEST_F(CanLinkTest, KeepsTheNewestSetPointOfEachIdWhileTheQueueIsFull) {
  up();
  bus_.send_error = ENOBUFS;
  for (std::uint8_t value = 1; value <= 3; ++value) {
    can::Frame left = kSetPoint, right = kSetPoint;
    right.id = 0x30D;
    left.data[0] = right.data[0] = value;
    link_.send(left, bus_.clock);
    link_.send(right, bus_.clock);
    bus_.clock += 20ms;
  }
  EXPECT_EQ(link_.counters().replaced, 4U);
  bus_.send_error = 0;
  tick();
  ASSERT_EQ(bus_.sent.size(), 2U);
  for (const can::Frame& frame : bus_.sent) EXPECT_EQ(frame.data[0], 3);
  tickFor(100ms);
  EXPECT_EQ(bus_.sent.size(), 2U);
}

TEST_F(CanLinkTest, NeverHoldsMoreThanItHasRoomFor) {
  up();
  bus_.send_error = ENOBUFS;
  for (std::uint32_t id = 0; id < 20; ++id) link_.send({.id = id}, bus_.clock);
  bus_.send_error = 0;
  bus_.clock += 5ms;
  tick();
  ASSERT_EQ(bus_.sent.size(), 8U);
  for (std::size_t i = 0; i < 8; ++i) EXPECT_EQ(bus_.sent[i].id, 12 + i) << "the newest, in order";
}

TEST_F(CanLinkTest, TriesAFullQueueOncePerFrameTime) {
  up();
  bus_.send_error = ENOBUFS;
  link_.send(kSetPoint, bus_.clock);
  for (int i = 0; i < 100; ++i) tick();  // at one instant
  EXPECT_EQ(bus_.sends, 1);
  tickFor(1s);
  EXPECT_EQ(bus_.sends, 201) << "one a tick";
  EXPECT_EQ(link_.counters().queue_full, 201U);
}

TEST_F(CanLinkTest, ForgetsSetPointsWhenTheBusIsLost) {
  for (const std::uint32_t lost : {std::uint32_t(ENETDOWN), std::uint32_t(ENODEV), kBusOff}) {
    tickFor(2s);
    ASSERT_TRUE(link_.usable());
    bus_.send_error = ENOBUFS;
    link_.send(kSetPoint, bus_.clock);
    if (lost == kBusOff) {
      bus_.putError(kBusOff);
    } else {
      bus_.pending_error = static_cast<int>(lost);
    }
    tick();
    ASSERT_FALSE(link_.usable());
    bus_.send_error = 0;
    link_.send(kSetPoint, bus_.clock);
    bus_.putError(kRestarted);
    tickFor(2s);
    EXPECT_TRUE(link_.usable());
    EXPECT_TRUE(bus_.sent.empty()) << lost;
  }
}

TEST_F(CanLinkTest, DetectsALossByTheErrorOfSending) {
  up();
  bus_.send_error = ENXIO;
  bus_.interface_error = bus_.open_error = ENODEV;
  link_.send(kSetPoint, bus_.clock);
  EXPECT_EQ(link_.state(), CanLinkState::kGone);
}

TEST_F(CanLinkTest, IsBlockedAfterAFewFramesThatTheInterfaceDoesNotTake) {
  for (const int error : {ENOBUFS, EAGAIN, EIO, EPERM, ENETDOWN, ENXIO}) {  // it is up, whatever it says
    tickFor(100ms);
    ASSERT_EQ(link_.state(), CanLinkState::kUp);
    const CanLinkCounters before = link_.counters();
    const bool full = error == ENOBUFS || error == EAGAIN;
    bus_.send_error = error;
    const auto sendFor = [&](Duration time) {
      for (const Timestamp end = bus_.clock + time; bus_.clock < end;) {
        bus_.clock += 5ms;
        tick();
        link_.send(kSetPoint, bus_.clock);
      }
    };
    sendFor(70ms);
    EXPECT_FALSE(link_.isBlocked());
    sendFor(20ms);
    EXPECT_TRUE(link_.isBlocked());
    sendFor(5s);
    EXPECT_TRUE(link_.isBlocked());
    EXPECT_EQ(link_.state(), CanLinkState::kUp) << "frames may come in";
    bus_.put(kData);
    tick();
    EXPECT_EQ(received_.size(), 1U);
    received_.clear();
    EXPECT_GE(link_.counters().queue_full - before.queue_full, full ? 900U : 0U);
    EXPECT_GE(link_.counters().send_errors - before.send_errors, full ? 0U : 900U);
    EXPECT_NEAR(static_cast<double>(link_.counters().opened - before.opened), full ? 0.0 : 5.0, 1.0);
    bus_.send_error = 0;
    sendFor(5ms);
    EXPECT_FALSE(link_.isBlocked());
  }
}

TEST_F(CanLinkTest, IsNotBlockedByASingleRefusalAfterALongSilence) {
  up();
  tickFor(10s);
  bus_.send_error = EIO;
  link_.send(kSetPoint, bus_.clock);
  EXPECT_FALSE(link_.isBlocked());
  bus_.interface_error = bus_.pending_error = ENETDOWN;
  tickFor(1s);
  EXPECT_EQ(link_.state(), CanLinkState::kDown);
  bus_.interface_error = 0;
  tickFor(1s);
  link_.send(kSetPoint, bus_.clock);
  EXPECT_FALSE(link_.isBlocked()) << "after it was down";
}

TEST_F(CanLinkTest, StaysErrorPassiveWithANewSocket) {
  up();
  bus_.putError(kController, kPassive);
  bus_.send_error = EIO;
  for (int i = 0; i < 100; ++i) {
    bus_.clock += 5ms;
    tick();
    link_.send(kSetPoint, bus_.clock);
  }
  EXPECT_GT(link_.counters().opened, 1U);
  EXPECT_EQ(link_.state(), CanLinkState::kErrorPassive);
}

TEST_F(CanLinkTest, ReportsWhetherAllWasTaken) {
  EXPECT_FALSE(link_.send(kSetPoint, bus_.clock)) << "not open yet";
  up();
  EXPECT_TRUE(link_.send(kSetPoint, bus_.clock));
  for (const int error : {ENOBUFS, EAGAIN, EIO}) {
    bus_.send_error = error;
    EXPECT_FALSE(link_.send(kSetPoint, bus_.clock));
    bus_.clock += 5ms;
    bus_.send_error = 0;
    can::Frame other = kSetPoint;
    other.id = 0x30D;
    const std::size_t before = bus_.sent.size();
    EXPECT_TRUE(link_.send(other, bus_.clock));
    EXPECT_EQ(bus_.sent.size(), before + 2);
  }
  bus_.send_error = ENETDOWN;
  EXPECT_FALSE(link_.send(kSetPoint, bus_.clock));
}

TEST_F(CanLinkTest, LooksForAMissingInterfaceAtItsPeriod) {
  CanLink link(std::make_unique<test::FakeCanPort>(bus_), "can0", {0x209}, 50ms);
  bus_.open_error = ENODEV;
  const auto ticks = [&](Duration time) {
    bus_.opens = 0;
    for (const Timestamp end = bus_.clock + time; bus_.clock < end; bus_.clock += 5ms) link.tick(bus_.clock);
  };
  ticks(10s);
  EXPECT_GE(bus_.opens, 199);
  EXPECT_LE(bus_.opens, 202);
  bus_.open_error = EAFNOSUPPORT;  // each of these attempts costs the kernel a search for a module
  ticks(1s);
  ticks(10s);
  EXPECT_LE(bus_.opens, 16);
}

TEST_F(CanLinkTest, DoesNotAllocate) {
  up();
  StampedCanFrame frame;
  for (int i = 0; i < 100; ++i) bus_.put(kData);
  bus_.sent.reserve(1000);
  EXPECT_EQ(test::allocationsDuring([&] {
              for (int i = 0; i < 100; ++i) {
                bus_.clock += 5ms;
                link_.tick(bus_.clock);
                link_.receive(frame);
                bus_.send_error = i % 3 == 0 ? ENOBUFS : 0;
                link_.send(kSetPoint, bus_.clock);
              }
            }),
            0U);
}

}  // namespace
}  // namespace slam::can_link_test
