// SPDX-License-Identifier: BSD-3-Clause
#include "tools/web/http_connection.hpp"

#include <array>
#include <chrono>
#include <gtest/gtest.h>
#include <limits>
#include <string>
#include <sys/socket.h>
#include <unistd.h>

namespace slam::http_connection_test {
namespace {

using namespace std::chrono_literals;

class Pair : public testing::Test {
 protected:
  Pair() { EXPECT_EQ(::socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0, ends_.data()), 0); }
  ~Pair() override {
    for (const int end : ends_) ::close(end);
  }
  void say(const std::string& text) {
    ASSERT_EQ(::send(ends_[1], text.data(), text.size(), 0), static_cast<ssize_t>(text.size()));
  }

  std::array<int, 2> ends_{};
  char bytes_[64] = {};
};

TEST_F(Pair, GivesBytesAsTheyCome) {
  HttpConnection connection(ends_[0], {});
  say("GET /");
  EXPECT_TRUE(connection.is_readable());
  EXPECT_EQ(connection.read(bytes_, 3), 3);
  EXPECT_EQ(connection.read(bytes_ + 3, 60), 2);
  EXPECT_STREQ(bytes_, "GET /");
  ::shutdown(ends_[1], SHUT_WR);
  EXPECT_EQ(connection.read(bytes_, 1), 0);
}

TEST_F(Pair, TakesNoMoreThanALimitOfBytes) {
  HttpConnection connection(ends_[0], {.request_size = 10});
  say("0123456789abcdef");
  EXPECT_EQ(connection.read(bytes_, 64), 10);
  EXPECT_EQ(connection.read(bytes_, 64), -1);
}

TEST_F(Pair, WaitsForTheWholeRequestNotForEachByte) {
  HttpConnection connection(ends_[0], {.request = 50ms, .request_size = std::numeric_limits<std::size_t>::max()});
  const auto end = std::chrono::steady_clock::now() + 5s;
  ssize_t got = 1;
  while (got > 0 && std::chrono::steady_clock::now() < end) {  // never without a byte to read
    say("x");
    got = connection.read(bytes_, 1);
  }
  EXPECT_EQ(got, -1);
}

TEST_F(Pair, GivesUpOnWhoDoesNotTakeTheAnswer) {
  HttpConnection connection(ends_[0], {.answer = 50ms, .least_rate = 1e9});
  const std::string answer(1 << 20, 'x');
  std::size_t sent = 0;
  ssize_t part = 1;
  while (part > 0 && sent < answer.size()) {
    part = connection.write(answer.data() + sent, answer.size() - sent);
    if (part > 0) sent += static_cast<std::size_t>(part);
  }
  EXPECT_EQ(part, -1);
  EXPECT_LT(sent, answer.size());
}

TEST_F(Pair, FailsQuietlyWhereNobodyIsLeft) {
  HttpConnection connection(ends_[0], {});
  ::shutdown(ends_[1], SHUT_RDWR);
  EXPECT_EQ(connection.write("answer", 6), -1);
}

}  // namespace
}  // namespace slam::http_connection_test
