// SPDX-License-Identifier: BSD-3-Clause
#include "bus/local_client.hpp"

#include <cerrno>
#include <filesystem>
#include <gtest/gtest.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include "bus/local_socket.hpp"
#include "tools/files.hpp"

namespace slam::local_client_test {
namespace {

using namespace std::chrono_literals;

class LocalClientTest : public testing::Test {
 protected:
  const test::Folder folder;
  const std::string path = folder / "socket";
};

TEST_F(LocalClientTest, ReportsWhyItCannotConnect) {
  LocalClient client;
  EXPECT_EQ(client.open(path), ENOENT);
  EXPECT_EQ(client.open(folder / "no/socket"), ENOENT);
  EXPECT_EQ(client.open(folder / std::string(200, 'x')), ENAMETOOLONG);
  EXPECT_EQ(client.open(folder.write("file", "")), ENOTSOCK);
  sockaddr_un address{};
  ASSERT_TRUE(toAddress(path, address));
  const int other = socket(AF_UNIX, SOCK_SEQPACKET | SOCK_CLOEXEC, 0);
  ASSERT_EQ(bind(other, reinterpret_cast<const sockaddr*>(&address), sizeof address), 0);
  EXPECT_EQ(client.open(path), ECONNREFUSED);
  ASSERT_EQ(listen(other, 0), 0);
  int error = 0;
  LocalClient clients[4];
  for (LocalClient& one : clients) error = error == 0 ? one.open(path) : error;
  EXPECT_EQ(error, EAGAIN) << "nobody takes them in, and nobody waits";
  ::close(other);
  EXPECT_FALSE(client.isOpen());
  EXPECT_FALSE(client.send("SAY", {}));
  EXPECT_FALSE(client.next(0ms));
}

TEST_F(LocalClientTest, IsRefusedWithoutTheGroup) {
  if (geteuid() != 0) GTEST_SKIP() << "only root can become somebody else";
  LocalSocket server(path);
  server.tend(Timestamp{});
  ASSERT_EQ(LocalClient::probe(path), 0);
  const pid_t stranger = fork();
  if (stranger == 0) {
    constexpr int kNobody = 65534;
    const bool changed = setgid(kNobody) == 0 && setuid(kNobody) == 0;
    _exit(changed && LocalClient::probe(path) == EACCES ? 0 : 1);
  }
  int status = 0;
  waitpid(stranger, &status, 0);
  EXPECT_EQ(status, 0);
}

TEST_F(LocalClientTest, SeesTheEndOfTheServer) {
  auto server = std::make_unique<LocalSocket>(path);
  server->tend(Timestamp{});
  LocalClient client;
  ASSERT_EQ(client.open(path), 0);
  server->receive();
  EXPECT_FALSE(client.next(0ms));
  EXPECT_TRUE(client.isOpen());
  server.reset();
  EXPECT_FALSE(client.next(1000ms));
  EXPECT_FALSE(client.isOpen());
}

}  // namespace
}  // namespace slam::local_client_test
