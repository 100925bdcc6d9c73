// SPDX-License-Identifier: BSD-3-Clause
#include "tools/web/event_hub.hpp"

#include <array>
#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/socket.h>
#include <unistd.h>
#include <utility>

namespace slam::event_hub_test {
namespace {

using namespace std::chrono_literals;
constexpr Timestamp kNow{Duration(100s)};

/// Both ends of a connection; the near one is the hub's.
class Connection {
 public:
  Connection() {
    std::array<int, 2> ends{};
    EXPECT_EQ(::socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0, ends.data()), 0);
    near_ = ends[0], far_ = ends[1];
  }
  ~Connection() { hangUp(); }
  int near() const { return near_; }
  void hangUp() {
    if (far_ >= 0) ::close(std::exchange(far_, -1));
  }
  /// What waits to be read.
  std::string text() const {
    std::string text;
    char part[4096];
    for (ssize_t got = 0; (got = ::recv(far_, part, sizeof part, MSG_DONTWAIT)) > 0;)
      text.append(part, static_cast<std::size_t>(got));
    return text;
  }
  bool isClosed() const {
    char byte = 0;
    return ::recv(far_, &byte, 1, MSG_DONTWAIT | MSG_PEEK) == 0;
  }
  void say(const std::string& text) const {
    EXPECT_EQ(::send(far_, text.data(), text.size(), 0), static_cast<ssize_t>(text.size()));
  }

 private:
  int near_ = -1, far_ = -1;
};

TEST(EventHub, SendsToAllWhoListen) {
  Connection a, b;
  EventHub hub;
  hub.add(a.near(), "hello a;", kNow);
  hub.add(b.near(), "hello b;", kNow);
  hub.send("news", kNow);
  EXPECT_EQ(a.text(), "hello a;news");
  EXPECT_EQ(b.text(), "hello b;news");
  EXPECT_EQ(hub.readers(), 2U);
}

TEST(EventHub, LetsGoOfWhoIsGone) {
  Connection a;
  EventHub hub;
  hub.add(a.near(), "", kNow);
  a.hangUp();
  hub.send("news", kNow);
  EXPECT_EQ(hub.readers(), 0U);
  EXPECT_EQ(::fcntl(a.near(), F_GETFD), -1) << "its socket is closed";
  EXPECT_EQ(hub.dropped(), 0U);
}

TEST(EventHub, LetsGoOfWhoDoesNotRead) {
  Connection slow, good;
  EventHub hub;
  hub.add(slow.near(), "", kNow);
  hub.add(good.near(), "", kNow);
  const std::string event(32 * 1024, 'x');
  for (int i = 0; i < 200 && hub.readers() == 2; ++i) {
    hub.send(event, kNow);
    EXPECT_EQ(good.text().size(), event.size()) << "the one does not wait for the other";
  }
  EXPECT_EQ(hub.readers(), 1U);
  EXPECT_EQ(hub.dropped(), 1U);
}

TEST(EventHub, LetsGoOfWhoTakesNothingForAWhileHoweverLittleItIs) {
  Connection sleeper;
  EventHub hub;
  const int little = 4096;
  setsockopt(sleeper.near(), SOL_SOCKET, SO_SNDBUF, &little, sizeof little);
  hub.add(sleeper.near(), std::string(100 * 1024, 'x'), kNow);
  hub.send("", kNow + 9s);
  EXPECT_EQ(hub.readers(), 1U);
  hub.send("", kNow + 11s);
  EXPECT_EQ(hub.readers(), 0U);
}

TEST(EventHub, KeepsTheOrderForWhoReadsSlowly) {
  Connection slow;
  EventHub hub;
  hub.add(slow.near(), "", kNow);
  std::string sent, read;
  for (int i = 0; i < 300; ++i) {
    const std::string event = std::to_string(i) + std::string(2000, ' ');
    hub.send(event, kNow);
    sent += event;
    if (i % 50 == 0) read += slow.text();
  }
  for (int i = 0; i < 20; ++i) {
    read += slow.text();
    hub.send("", kNow);
  }
  EXPECT_EQ(read + slow.text(), sent);
}

TEST(EventHub, GivesThePlaceOfTheOldestOfWhoHasMostToANewReader) {
  std::vector<Connection> connections(EventHub::kMostReaders + 2);
  EventHub hub;
  hub.add(connections[0].near(), "", kNow, "b");
  for (std::size_t i = 1; i < EventHub::kMostReaders; ++i) hub.add(connections[i].near(), "", kNow, "a");
  EXPECT_EQ(hub.dropped(), 0U);
  hub.add(connections[EventHub::kMostReaders].near(), "", kNow, "a");
  hub.add(connections[EventHub::kMostReaders + 1].near(), "", kNow, "c");
  EXPECT_EQ(hub.readers(), EventHub::kMostReaders);
  EXPECT_EQ(hub.dropped(), 2U);
  EXPECT_TRUE(connections[1].isClosed() && connections[2].isClosed());
  hub.send("news", kNow);
  EXPECT_EQ(connections[0].text(), "news") << "although it is the oldest";
  EXPECT_EQ(connections.back().text(), "news");
}

TEST(EventHub, ThrowsAwayWhatAReaderSends) {
  Connection talker;
  EventHub hub;
  hub.add(talker.near(), "", kNow);
  for (int i = 0; i < 1000; ++i) {
    talker.say(std::string(400, 'y'));
    hub.send("", kNow);
  }
  hub.send("news", kNow);
  EXPECT_EQ(talker.text(), "news");
}

}  // namespace
}  // namespace slam::event_hub_test
