// SPDX-License-Identifier: BSD-3-Clause
#include "bus/udpm/multicast_receiver.hpp"

#include <gtest/gtest.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include "bus/packets.hpp"
#include "support/network.hpp"

namespace slam::multicast_receiver_test {
namespace {

using test::OtherMachine;
using test::shell;
using Bytes = std::vector<std::uint8_t>;
using Joined = MulticastReceiver::Joined;

/// In a network namespace of its own, with the route on lo at first.
class MulticastReceiving : public testing::Test {
 protected:
  MulticastReceiving() : url_(parseUdpmUrl("udpm://239.255.76.67:7667?ttl=1")), receiver_(url_) {}
  ~MulticastReceiving() override {
    EXPECT_TRUE(shell("ip route replace 224.0.0.0/4 dev lo"));
    close(sender_);
  }

  bool send(const Bytes& datagram) const {
    return sendto(sender_, datagram.data(), datagram.size(), 0, reinterpret_cast<const sockaddr*>(&url_.group),
                  sizeof url_.group) == static_cast<ssize_t>(datagram.size());
  }
  /// The next datagram, within a second.
  std::optional<Bytes> next() {
    pollfd waiting{receiver_.descriptor(), POLLIN, 0};
    poll(&waiting, 1, 1000);
    const auto datagram = receiver_.next();
    return datagram ? std::optional(Bytes(datagram->begin(), datagram->end())) : std::nullopt;
  }
  bool arrives(const Bytes& datagram) { return send(datagram) && next() == datagram; }

  const UdpmUrl url_;
  MulticastReceiver receiver_;
  const int sender_ = socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0);
};

TEST_F(MulticastReceiving, TakesDatagramsOfAnySizeAndContent) {
  ASSERT_EQ(receiver_.join(), Joined::kAnew);
  EXPECT_EQ(receiver_.next(), std::nullopt);
  for (const Bytes& datagram : {Bytes{}, Bytes{1}, Bytes(65507, 0x5A), test::deadlyFragment("SLAM_COMMAND")}) {
    EXPECT_TRUE(arrives(datagram)) << datagram.size();
  }
  EXPECT_EQ(receiver_.next(), std::nullopt);
}

TEST_F(MulticastReceiving, SharesThePortWithOthers) {
  MulticastReceiver other(url_);
  ASSERT_EQ(other.join(), Joined::kAnew);
  ASSERT_EQ(receiver_.join(), Joined::kAnew);
  EXPECT_TRUE(arrives({1, 2, 3}));
  EXPECT_TRUE(other.next());
}

TEST_F(MulticastReceiving, StaysWhereTheRouteStays) {
  ASSERT_EQ(receiver_.join(), Joined::kAnew);
  const int descriptor = receiver_.descriptor();
  for (int i = 0; i < 100; ++i) ASSERT_EQ(receiver_.join(), Joined::kAsBefore);
  EXPECT_EQ(receiver_.descriptor(), descriptor);
  EXPECT_TRUE(arrives({1}));
}

TEST_F(MulticastReceiving, ReportsThatThereIsNoRouteAndWaitsForIt) {
  ASSERT_TRUE(shell("ip route del 224.0.0.0/4"));
  EXPECT_EQ(receiver_.join(), Joined::kNoRoute);
  EXPECT_EQ(receiver_.descriptor(), -1);
  EXPECT_EQ(receiver_.next(), std::nullopt);
  ASSERT_TRUE(shell("ip route add 224.0.0.0/4 dev lo"));
  EXPECT_EQ(receiver_.join(), Joined::kAnew);
  ASSERT_TRUE(shell("ip route del 224.0.0.0/4"));
  EXPECT_EQ(receiver_.join(), Joined::kNoRoute);
  ASSERT_TRUE(shell("ip route add 224.0.0.0/4 dev lo"));
  EXPECT_EQ(receiver_.join(), Joined::kAsBefore);
  EXPECT_TRUE(arrives({1}));
}

TEST_F(MulticastReceiving, FollowsTheRouteToAnotherInterface) {
  const OtherMachine other;
  other.plug("cable", 1);
  other.plug("wlan", 2);
  other.route("cable");
  ASSERT_EQ(receiver_.join(), Joined::kAnew);
  EXPECT_TRUE(arrives({1}));
  for (int i = 0; i < 30; ++i) {  // more often than a socket may have memberships (net.ipv4.igmp_max_memberships)
    other.route(i % 2 == 0 ? "wlan" : "cable");
    ASSERT_EQ(receiver_.join(), Joined::kAnew) << i;
    EXPECT_TRUE(arrives({2})) << i;
    EXPECT_EQ(receiver_.join(), Joined::kAsBefore) << i;
  }
  EXPECT_TRUE(shell("grep -A1 cable /proc/net/igmp | grep -q 434CFFEF")) << "a member there";
  EXPECT_FALSE(shell("grep -A1 wlan /proc/net/igmp | grep -q 434CFFEF")) << "where it was one before";
}

TEST_F(MulticastReceiving, FindsAnInterfaceThatWentAndCameWithItsName) {
  const OtherMachine other;
  for (int i = 0; i < 3; ++i) {
    other.plug("wlan", 2);
    other.route("wlan");
    ASSERT_EQ(receiver_.join(), Joined::kAnew) << i;
    EXPECT_TRUE(arrives({1})) << i;
    ASSERT_TRUE(shell("ip link del wlan"));
    EXPECT_EQ(receiver_.join(), Joined::kNoRoute) << i;
  }
}

TEST_F(MulticastReceiving, CountsWhatTheKernelHadNoRoomFor) {
  ASSERT_EQ(receiver_.join(), Joined::kAnew);
  constexpr int kSent = 2000;
  for (int i = 0; i < kSent; ++i) ASSERT_TRUE(send(Bytes(10000, 1)));
  int arrived = 0;
  while (receiver_.next()) ++arrived;
  EXPECT_TRUE(arrives({1})) << "the first one behind the gap carries the count";
  EXPECT_LT(arrived, kSent);
  EXPECT_EQ(receiver_.dropped(), static_cast<std::uint64_t>(kSent - arrived));
}

TEST_F(MulticastReceiving, ReportsThatThePortIsAnotherPrograms) {
  const int other = socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0);
  ASSERT_EQ(bind(other, reinterpret_cast<const sockaddr*>(&url_.group), sizeof url_.group), 0);
  EXPECT_EQ(receiver_.join(), Joined::kNoSocket);
  close(other);
  EXPECT_EQ(receiver_.join(), Joined::kAnew);
}

}  // namespace
}  // namespace slam::multicast_receiver_test
