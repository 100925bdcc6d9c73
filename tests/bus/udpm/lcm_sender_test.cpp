// SPDX-License-Identifier: BSD-3-Clause
#include "bus/udpm/lcm_sender.hpp"

#include <atomic>
#include <gtest/gtest.h>
#include <thread>
#include <vector>

#include "bus/udpm/lcm_link.hpp"
#include "support/wait_until.hpp"

namespace slam::lcm_sender_test {
namespace {

constexpr char kUrl[] = "udpm://239.255.76.67:7673?ttl=0";
const std::vector<std::uint8_t> kData{1, 2, 3};

TEST(LcmSender, SendsNothingWhileClosed) {
  LcmSender sender(parseUdpmUrl(kUrl));
  EXPECT_FALSE(sender.publish("A", kData).sent);
  EXPECT_EQ(sender.publish("A", kData).error, 0) << "nothing was tried";
  sender.open(0);
  sender.close();
  EXPECT_FALSE(sender.publish("A", kData).sent) << "the newest that was handed over counts";
}

TEST(LcmSender, SendsNoPacketThatWouldLeaveTheMachine) {
  MulticastRoute route(parseUdpmUrl(kUrl));
  const auto interface = route.interface();
  if (!interface) GTEST_SKIP() << "this machine has no multicast";
  LcmSender sender(parseUdpmUrl(kUrl));
  sender.open(*interface);
  EXPECT_TRUE(sender.publish("A", kData).sent);
  sender.open(*interface + 1);
  EXPECT_FALSE(sender.publish("A", kData).sent) << "its socket belongs to another interface than the route's";
}

TEST(LcmSender, IsOpenedAndClosedByAnotherThreadWhileItSends) {
  const auto interface = MulticastRoute(parseUdpmUrl(kUrl)).interface();
  if (!interface) GTEST_SKIP() << "this machine has no multicast";
  LcmSender sender(parseUdpmUrl(kUrl));
  std::atomic<int> opened{0}, sent{0};
  std::atomic<bool> quit{false};
  std::thread sending([&] {
    while (!quit) sent += sender.publish("A", kData).sent ? 1 : 0;
  });
  for (; opened < 50; ++opened) {
    const int before = sent;
    sender.open(*interface);
    EXPECT_TRUE(test::waitUntil([&] { return sent > before + 1; })) << opened;
    sender.close();
    sender.collect();
  }
  quit = true;
  sending.join();
}

TEST(LcmSender, IsOpenedByItsLinkAndKnownToItsWatch) {
  LcmLink link(kUrl);
  Timestamp now{std::chrono::seconds(1000)};
  link.tend(now);
  if (link.descriptor() < 0) GTEST_SKIP() << "this machine has no multicast";
  for (const Timestamp end = now + std::chrono::seconds(1); now < end; now += std::chrono::milliseconds(10)) {
    link.published("A", kData, link.sender().publish("A", kData), now);
    link.receive();  // a packet on lo has arrived when it has been sent
  }
  EXPECT_EQ(link.state(now), LinkState::kConnected);
}

}  // namespace
}  // namespace slam::lcm_sender_test
