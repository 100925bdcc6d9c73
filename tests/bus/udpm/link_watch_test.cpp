// SPDX-License-Identifier: BSD-3-Clause
#include "bus/udpm/link_watch.hpp"

#include <cerrno>
#include <gmock/gmock.h>

namespace slam::link_watch_test {
namespace {

using namespace std::chrono_literals;
using Bytes = std::vector<std::uint8_t>;

class LinkWatched : public testing::Test {
 protected:
  /// Sends a message every 10 ms. @param returned whether a copy of the n-th comes back
  template <typename Returned>
  void sendFor(Duration time, Returned&& returned) {
    for (const Timestamp end = now_ + time; now_ < end; now_ += 10ms) {
      const auto n = static_cast<std::uint8_t>(count_ % 251), m = static_cast<std::uint8_t>(count_ / 251);
      const Bytes message = {n, m, 3};
      watch_.sent("POSE", message, now_);
      watch_.received({Packet::kMessage, "POSE", Bytes{n, m, 4}});  // another slamd's
      watch_.received({Packet::kMessage, "POSE2", message});        // on another channel
      if (returned(count_)) watch_.received({Packet::kMessage, "POSE", message});
      ++count_;
    }
  }
  void failFor(Duration time, int error) {
    for (const Timestamp end = now_ + time; now_ < end; now_ += 10ms) watch_.failed(error, now_);
  }
  LinkState state() const { return watch_.state(now_); }

  LinkWatch watch_;
  Timestamp now_{1000s};
  int count_ = 0;
};

constexpr auto kAll = [](int) { return true; };
constexpr auto kNone = [](int) { return false; };

TEST_F(LinkWatched, IsConnectedWhenItsOwnPacketsComeBack) {
  EXPECT_EQ(state(), LinkState::kOpening);
  sendFor(100ms, kAll);
  EXPECT_EQ(state(), LinkState::kConnected);
}

TEST_F(LinkWatched, ForgivesThatMostPacketsGetLostUnderLoad) {
  for (int second = 0; second < 60; ++second) {
    sendFor(1s, [](int n) { return n % 3 == 0; });
    EXPECT_EQ(state(), LinkState::kConnected) << second;
  }
}

TEST_F(LinkWatched, HasNoLoopbackWhenNothingComesBack) {
  sendFor(1s, kAll);
  sendFor(1500ms, kNone);
  EXPECT_EQ(state(), LinkState::kConnected);
  sendFor(1s, kNone);
  EXPECT_EQ(state(), LinkState::kNoLoopback);
  sendFor(60s, kNone);
  EXPECT_EQ(state(), LinkState::kNoLoopback);
  sendFor(500ms, kAll);
  EXPECT_EQ(state(), LinkState::kConnected);
}

TEST_F(LinkWatched, DoesNotDoubtTheNetworkWhileItReadsTooLittleItself) {
  sendFor(1s, kAll);
  for (int i = 0; i < 20; ++i) {
    sendFor(1s, kNone);
    watch_.missed();
    EXPECT_EQ(state(), LinkState::kConnected) << i;
  }
  sendFor(3s, kNone);
  EXPECT_EQ(state(), LinkState::kNoLoopback) << "it reads all, and nothing comes";
}

TEST_F(LinkWatched, HasNoLoopbackFromTheStartWhereAFirewallIs) {
  sendFor(3s, kNone);
  EXPECT_EQ(state(), LinkState::kNoLoopback);
}

TEST_F(LinkWatched, DistinguishesAMissingRouteFromAProhibition) {
  sendFor(1s, kAll);
  failFor(300ms, ENETUNREACH);
  EXPECT_EQ(state(), LinkState::kConnected) << "one that is renewed";
  failFor(300ms, ENETUNREACH);
  EXPECT_EQ(state(), LinkState::kNoRoute);
  failFor(10ms, EPERM);
  EXPECT_EQ(state(), LinkState::kBlocked);
  sendFor(1s, kAll);
  EXPECT_EQ(state(), LinkState::kConnected);
}

TEST_F(LinkWatched, DoesNotCountTimeWithoutARouteAsSilence) {
  sendFor(1s, kNone);
  failFor(10s, ENETUNREACH);
  sendFor(10ms, kNone);
  EXPECT_NE(state(), LinkState::kNoLoopback);
  sendFor(2s, kNone);
  EXPECT_EQ(state(), LinkState::kNoLoopback);
}

TEST_F(LinkWatched, HasNothingToReportWhereNothingIsSent) {
  now_ += 60s;
  EXPECT_EQ(state(), LinkState::kOpening);
}

TEST(LinkProblem, NamesCauseAndFix) {
  UdpmUrl url = parseUdpmUrl("udpm://239.255.76.67:7668?ttl=0");
  for (const LinkState state :
       {LinkState::kNoRoute, LinkState::kBlocked, LinkState::kNoLoopback, LinkState::kNoSocket}) {
    EXPECT_TRUE(isFault(state));
    EXPECT_FALSE(problemOf(state, url).fix().empty());
  }
  for (const LinkState state : {LinkState::kOpening, LinkState::kConnected}) {
    EXPECT_FALSE(isFault(state));
    EXPECT_FALSE(problemOf(state, url));
  }
  EXPECT_EQ(problemOf(LinkState::kNoLoopback, url).cause(), "sent packets do not come back; is udp 7668 blocked?");
}

TEST(LinkProblem, RecommendsTheRouteOnLoOnlyToWhatStaysOnThisMachine) {
  EXPECT_THAT(problemOf(LinkState::kNoRoute, parseUdpmUrl("udpm://239.255.76.67:7667?ttl=0")).fix(),
              testing::HasSubstr("dev lo"));
  const std::string network = problemOf(LinkState::kNoRoute, parseUdpmUrl("udpm://239.255.76.67:7667?ttl=1")).fix();
  EXPECT_THAT(network, testing::Not(testing::HasSubstr("dev lo")));
  EXPECT_THAT(network, testing::HasSubstr("ip route add 224.0.0.0/4 dev "));
}

}  // namespace
}  // namespace slam::link_watch_test
