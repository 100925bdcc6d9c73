// SPDX-License-Identifier: BSD-3-Clause
#include "bus/udpm/lcm_link.hpp"

#include <filesystem>
#include <gtest/gtest.h>

#include "support/network.hpp"

namespace slam::lcm_link_test {
namespace {

using namespace std::chrono_literals;
using test::Firewall;
using test::OtherMachine;
using test::shell;
using Bytes = std::vector<std::uint8_t>;
constexpr int kOpen = 12;  // descriptors that a link and its sender may hold beyond those of a closed one

std::ptrdiff_t entriesOf(const char* folder) {
  return std::distance(std::filesystem::directory_iterator(folder), std::filesystem::directory_iterator());
}

/// In a network namespace of its own, with the route on lo at first. Time is the test's: no call may wait for it.
class Link : public testing::Test {
 protected:
  Link() {
    link_.subscribe("POSE", [this](auto data) { received_.emplace_back(data.begin(), data.end()); });
  }
  ~Link() override { EXPECT_TRUE(shell("ip route replace 224.0.0.0/4 dev lo")); }

  /// What slamd's thread does a hundred times a second.
  void runFor(Duration time) {
    for (const Timestamp end = now_ + time; now_ < end; now_ += 10ms) {
      link_.tend(now_);
      const auto n = static_cast<std::uint32_t>(++sent_);
      link_.publish("POSE", Bytes{static_cast<std::uint8_t>(n >> 8), static_cast<std::uint8_t>(n)}, now_);
      link_.receive();  // a packet on lo has arrived when it has been sent
    }
  }
  LinkState state() const { return link_.state(now_); }

  LcmLink link_{"udpm://239.255.76.67:7667?ttl=1"};
  Timestamp now_{1000s};
  int sent_ = 0;
  std::vector<Bytes> received_;
};

TEST_F(Link, ReceivesWhatItSends) {
  runFor(1s);
  EXPECT_EQ(state(), LinkState::kConnected);
  EXPECT_EQ(received_.size(), 100U);
  EXPECT_EQ(entriesOf("/proc/self/task"), 1) << "liblcm's receiver has a thread";
}

TEST_F(Link, KeepsNoDescriptorsBehindAFirewall) {
  if (!Firewall::isThere()) GTEST_SKIP() << "without nftables";
  for (const auto& [hook, expected] : {std::pair("input", LinkState::kNoLoopback), {"output", LinkState::kBlocked}}) {
    const auto before = entriesOf("/proc/self/fd");
    {
      const Firewall firewall(hook);
      runFor(5s);
      EXPECT_EQ(state(), expected) << hook;
      runFor(200s);
      EXPECT_EQ(state(), expected) << hook;
    }
    EXPECT_LE(entriesOf("/proc/self/fd"), before + kOpen);
    EXPECT_EQ(entriesOf("/proc/self/task"), 1);
    received_.clear();
    runFor(10s);
    EXPECT_EQ(state(), LinkState::kConnected) << hook;
    EXPECT_GT(received_.size(), 900U);
  }
}

TEST_F(Link, KeepsNoDescriptorsWithoutARoute) {
  const auto before = entriesOf("/proc/self/fd");
  for (int i = 0; i < 5; ++i) {
    ASSERT_TRUE(shell("ip route del 224.0.0.0/4"));
    runFor(20s);
    EXPECT_EQ(state(), LinkState::kNoRoute);
    ASSERT_TRUE(shell("ip route add 224.0.0.0/4 dev lo"));
    runFor(3s);
    EXPECT_EQ(state(), LinkState::kConnected);
  }
  EXPECT_LE(entriesOf("/proc/self/fd"), before + kOpen);
}

TEST_F(Link, FollowsTheRouteWithinSeconds) {
  const OtherMachine other;
  other.plug("cable", 1);
  other.plug("wlan", 2);
  for (const char* name : {"cable", "wlan", "cable"}) {
    other.route(name);
    runFor(2s);
    received_.clear();
    runFor(1s);
    EXPECT_EQ(received_.size(), 100U) << name;
    EXPECT_EQ(state(), LinkState::kConnected) << name;
  }
}

TEST_F(Link, OfTtlZeroNeverSendsWhereItIsNoMember) {
  if (!Firewall::isThere()) GTEST_SKIP() << "without nftables to count with";
  const OtherMachine other;
  other.plug("cable", 1);
  other.plug("wlan", 2);
  ASSERT_TRUE(shell(other.inside("nft add table inet lcm")));
  ASSERT_TRUE(shell(other.inside("nft add chain inet lcm seen '{ type filter hook prerouting priority 0; }'")));
  ASSERT_TRUE(shell(other.inside("nft add rule inet lcm seen udp dport 7667 counter")));
  LcmLink link("udpm://239.255.76.67:7667?ttl=0");
  int received = 0;
  link.subscribe("POSE", [&](auto) { ++received; });
  for (const char* name : {"cable", "wlan", "cable", "lo", "cable", "lo", "wlan"}) {
    ASSERT_TRUE(shell(std::string("ip route replace 224.0.0.0/4 dev ") + name));
    for (const Timestamp end = now_ + 1500ms; now_ < end; now_ += 10ms) {
      link.publish("POSE", Bytes{static_cast<std::uint8_t>(++sent_)}, now_);
      link.receive();
      link.tend(now_);
    }
  }
  EXPECT_GT(received, 900);
  EXPECT_TRUE(shell(other.inside("nft list ruleset | grep -q 'counter packets 0 '")));
}

TEST_F(Link, RecoversAMembershipThatTheKernelForgot) {
  runFor(1s);
  // An MTU below 68 bytes takes IPv4 off an interface, and its groups with it; its number stays.
  ASSERT_TRUE(shell("ip link set lo mtu 60 && ip link set lo mtu 65536 && ip addr add 127.0.0.1/8 dev lo"));
  ASSERT_TRUE(shell("ip route replace 224.0.0.0/4 dev lo"));
  runFor(1s);
  received_.clear();
  runFor(1s);
  EXPECT_TRUE(received_.empty()) << "the kernel remembers: there is nothing to recover from";
  runFor(5s);
  received_.clear();
  runFor(1s);
  EXPECT_EQ(received_.size(), 100U);
  EXPECT_EQ(state(), LinkState::kConnected);
}

}  // namespace
}  // namespace slam::lcm_link_test
