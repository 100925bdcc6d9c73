// SPDX-License-Identifier: BSD-3-Clause
#include "tools/web/connection_room.hpp"

#include <array>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <map>
#include <sys/socket.h>
#include <unistd.h>

namespace slam::connection_room_test {
namespace {

using namespace std::chrono_literals;
using testing::ElementsAre;
using testing::IsEmpty;

TEST(WholeRequest, EndsWithItsHeadOrItsBody) {
  for (const char* whole :
       {"GET / HTTP/1.1\r\nHost: a\r\n\r\n", "POST / HTTP/1.1\r\ncontent-LENGTH: 2\r\n\r\n{}",
        "POST / HTTP/1.1\r\nContent-Length: a lot\r\n\r\n", "POST / HTTP/1.1\r\nContent-Length:2\r\nA: b\r\n\r\n{}x",
        "POST / HTTP/1.1\r\nTransfer-Encoding: chunked\r\n\r\n1\r\na\r\n0\r\n\r\n", "\r\n\r\n"})
    EXPECT_TRUE(isWholeRequest(whole)) << whole;
  for (const char* part :
       {"", "GET / HT", "GET / HTTP/1.1\r\nHost: a\r\n", "POST / HTTP/1.1\r\nContent-Length: 3\r\n\r\n{}",
        "POST / HTTP/1.1\r\nTransfer-Encoding: chunked\r\n\r\n1\r\na\r\n"})
    EXPECT_FALSE(isWholeRequest(part)) << part;
}

class Room : public testing::Test {
 protected:
  ~Room() override {
    for (const auto& [name, socket] : clients_) ::close(socket);
  }
  void come(const std::string& name, const std::string& address) {
    std::array<int, 2> pair{};
    ASSERT_EQ(socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0, pair.data()), 0);
    clients_[name] = pair[0];
    room_.add(pair[1], address, now_);
    names_[pair[1]] = name;
  }
  void say(const std::string& name, const std::string& text) {
    ASSERT_EQ(::send(clients_[name], text.data(), text.size(), MSG_NOSIGNAL), static_cast<ssize_t>(text.size()));
  }
  std::vector<std::string> ready() {
    std::vector<std::string> names;
    room_.wait(0ms);
    for (const ConnectionRoom::Connection& connection : room_.takeReady(now_)) {
      names.push_back(names_[connection.socket]);
      ::close(connection.socket);
    }
    return names;
  }
  bool isRefused(const std::string& name) {
    char text[128];
    const ssize_t size = ::recv(clients_[name], text, sizeof text, MSG_DONTWAIT);
    return size > 0 && std::string(text, static_cast<std::size_t>(size)).starts_with("HTTP/1.1 408");
  }

  static constexpr const char* kWhole = "GET / HTTP/1.1\r\n\r\n";
  ConnectionRoom room_{{.request = 5s, .request_size = 1000, .most = 4}};
  Timestamp now_{1000s};
  std::map<std::string, int> clients_;
  std::map<int, std::string> names_;
};

TEST_F(Room, HandsOnWhoseRequestIsWhole) {
  come("slow", "a"), come("quick", "a");
  say("slow", "GET / HT");
  say("quick", kWhole);
  EXPECT_THAT(ready(), ElementsAre("quick"));
  say("slow", "TP/1.1\r\n\r\n");
  EXPECT_THAT(ready(), ElementsAre("slow"));
  come("long", "a"), come("ends", "a"), come("gone", "a");
  say("long", std::string(1000, 'x'));
  say("ends", "GET / HT");
  ::shutdown(clients_["ends"], SHUT_WR);
  ::close(clients_["gone"]);
  clients_.erase("gone");
  EXPECT_THAT(ready(), ElementsAre("long", "ends", "gone")) << "nothing more is to be waited for";
  EXPECT_EQ(room_.dropped(), 0U);
}

TEST_F(Room, RefusesWhoTakesTooLong) {
  come("slow", "a");
  for (int i = 0; i < 5; ++i) {
    say("slow", "G");  // byte by byte
    EXPECT_THAT(ready(), IsEmpty());
    now_ += 1s;
  }
  EXPECT_EQ(room_.size(), 1U);
  now_ += 1ms;
  EXPECT_THAT(ready(), IsEmpty());
  EXPECT_EQ(room_.size(), 0U);
  EXPECT_TRUE(isRefused("slow"));
}

TEST_F(Room, TakesThePlaceOfTheOldestOfWhoHasMost) {
  come("other", "b");
  for (const char* name : {"1", "2", "3", "4", "5"}) come(name, "a");
  EXPECT_EQ(room_.size(), 4U);
  EXPECT_TRUE(isRefused("1") && isRefused("2"));
  EXPECT_FALSE(isRefused("other")) << "although it has waited for longer";
  come("new", "c");
  EXPECT_TRUE(isRefused("3"));
  say("other", kWhole), say("new", kWhole), say("5", kWhole);
  EXPECT_THAT(ready(), ElementsAre("other", "5", "new"));
  EXPECT_EQ(room_.dropped(), 3U);
}

}  // namespace
}  // namespace slam::connection_room_test
