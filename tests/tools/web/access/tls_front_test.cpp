// SPDX-License-Identifier: BSD-3-Clause
#include "tools/web/access/tls_front.hpp"

#include <array>
#include <cerrno>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <openssl/ssl.h>
#include <sys/socket.h>
#include <unistd.h>

#include "support/wait_until.hpp"
#include "tools/files.hpp"

namespace slam::tls_front_test {
namespace {

using namespace std::chrono_literals;
using test::waitUntil;

class TlsFrontTest : public testing::Test {
 protected:
  void build(const TlsLimits& limits) {
    front_ = std::make_unique<TlsFront>(
        tlsContextOf(WebConfig{}, folder_ / "state", {}),
        [this](int socket, const std::string& address, bool is_tls) {
          const std::lock_guard lock(mutex_);
          taken_.push_back({socket, is_tls});
          EXPECT_EQ(address, "a");
        },
        limits);
  }
  ~TlsFrontTest() override {
    for (const Taken& one : taken_) ::close(one.socket);
    for (const int socket : far_) ::close(socket);
  }
  /// A connection's far end.
  int connect() {
    std::array<int, 2> ends{};
    EXPECT_EQ(::socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0, ends.data()), 0);
    far_.push_back(ends[1]);
    front_->add(ends[0], "a");
    return ends[1];
  }
  bool isTaken() {
    const std::lock_guard lock(mutex_);
    return !taken_.empty();
  }
  static bool isClosed(int socket) {
    char byte = 0;
    return ::recv(socket, &byte, 1, MSG_DONTWAIT | MSG_PEEK) == 0;
  }

  struct Taken {
    int socket;
    bool is_tls;
  };
  test::Folder folder_;
  std::mutex mutex_;
  std::vector<Taken> taken_;
  std::vector<int> far_;
  std::unique_ptr<TlsFront> front_;
};

TEST_F(TlsFrontTest, CarriesBytesInBothDirections) {
  build({.buffer = 4096});
  const int far = connect();
  const std::unique_ptr<SSL_CTX, SslContextDeleter> context(SSL_CTX_new(TLS_client_method()));
  SSL* client = SSL_new(context.get());
  SSL_set_fd(client, far);
  ASSERT_EQ(SSL_connect(client), 1);
  ASSERT_TRUE(waitUntil([&] { return isTaken(); }));
  EXPECT_TRUE(taken_[0].is_tls);
  ASSERT_EQ(SSL_write(client, "question", 8), 8);
  std::string got(8, ' ');
  ASSERT_TRUE(waitUntil([&] { return ::recv(taken_[0].socket, got.data(), 8, MSG_PEEK | MSG_DONTWAIT) == 8; }));
  EXPECT_EQ(got, "question");
  const std::string answer(300'000, 'x');  // many times the buffer
  std::thread server([&] {
    for (std::size_t at = 0; at < answer.size();) {  // this end does not wait for room
      const ssize_t sent = ::send(taken_[0].socket, answer.data() + at, answer.size() - at, MSG_NOSIGNAL);
      if (sent > 0) at += static_cast<std::size_t>(sent);
      if (sent < 0 && errno != EAGAIN) break;
    }
    ::close(std::exchange(taken_[0].socket, -1));
  });
  std::string all;
  std::array<char, 4096> part{};
  for (int size = 0; (size = SSL_read(client, part.data(), part.size())) > 0;)
    all.append(part.data(), static_cast<std::size_t>(size));
  server.join();
  EXPECT_EQ(all, answer);
  SSL_free(client);
  EXPECT_TRUE(waitUntil([&] { return front_->connections() == 0; }));
}

TEST_F(TlsFrontTest, PassesPlainConnectionsOnUntouched) {
  build({});
  const int far = connect();
  ASSERT_EQ(::send(far, "GET / ", 6, 0), 6);
  ASSERT_TRUE(waitUntil([&] { return isTaken(); }));
  EXPECT_FALSE(taken_[0].is_tls);
  std::array<char, 6> got{};
  EXPECT_EQ(::recv(taken_[0].socket, got.data(), got.size(), MSG_DONTWAIT), 6);
}

TEST_F(TlsFrontTest, DropsWhoMakesNoHandshake) {
  build({.handshake = 50ms});
  const int silent = connect(), wrong = connect();
  ASSERT_EQ(::send(wrong, "\x16garbage garbage", 16, 0), 16);
  EXPECT_TRUE(waitUntil([&] { return front_->dropped() == 2 && front_->connections() == 0; }));
  EXPECT_TRUE(isClosed(silent));
  EXPECT_FALSE(isTaken());
}

TEST_F(TlsFrontTest, MakesPlaceForTheNewest) {
  build({.most = 2});
  const int first = connect();
  connect();
  connect();
  EXPECT_TRUE(waitUntil([&] { return isClosed(first); }));
  EXPECT_EQ(front_->connections(), 2U);
}

}  // namespace
}  // namespace slam::tls_front_test
