// SPDX-License-Identifier: BSD-3-Clause
#include "tools/slamctl/remote.hpp"

#include <atomic>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <memory>
#include <poll.h>
#include <slam/command_t.hpp>
#include <thread>

#include "bus/channels.hpp"
#include "bus/checked_decode.hpp"
#include "bus/encoding.hpp"
#include "bus/local_socket.hpp"
#include "bus/problem_message.hpp"
#include "config/service_reach.hpp"
#include "problems/answers.hpp"
#include "runtime/clock.hpp"
#include "tools/files.hpp"

namespace slam::remote_test {
namespace {

using namespace std::chrono_literals;
using testing::HasSubstr;

/// What slamd has at the other end of the socket.
class Daemon {
 public:
  explicit Daemon(const std::string& path) : socket_(path) {
    socket_.subscribe(channel::kCommand, [this](LocalSocket::Client from, std::span<const std::uint8_t> data) {
      const auto command = decodeChecked<command_t>(data);
      if (!command || command->verb == "be_silent") return;
      ack_t ack{};
      ack.id = command->id - 1;  // another's answer first
      ack.message = "not for you";
      socket_.send(from, channel::kAck, test::encoded(ack));
      ack.id = command->id;
      ack.accepted = true;
      ack.utime = 5;
      problems_t parts{};
      parts.utime = command->verb == "save" ? ack.utime : ack.utime - 1;  // else another answer's
      parts.problems = {toMessage("command", {answer::kSaved, {}, {command->argument}}, false)};
      parts.nproblems = 1;
      socket_.send(from, channel::kAnswer, test::encoded(parts));
      ack.message = command->verb + " " + command->argument + " " + std::to_string(command->pose[1]);
      socket_.send(from, channel::kAck, test::encoded(ack));
    });
    socket_.tend(monotonicNow());
    thread_ = std::thread([this] { run(); });
  }
  ~Daemon() {
    ends_ = true;
    thread_.join();
  }

 private:
  void run() {
    health_t health{};
    while (!ends_) {
      pollfd waiting{socket_.descriptor(), POLLIN, 0};
      ::poll(&waiting, 1, 10);
      socket_.receive();
      health.summary = "message " + std::to_string(++count_);
      socket_.sendAll(channel::kHealth, test::encoded(health));
    }
  }
  LocalSocket socket_;
  std::atomic<bool> ends_{false};
  int count_ = 0;
  std::thread thread_;
};

class RemoteTest : public testing::Test {
 protected:
  const test::Folder folder;
  const std::string socket = folder / "socket";
  const std::string url = "udpm://239.255.76.67:7668?ttl=0";  // nobody is there, with a network or without one
  std::string wordsOf(Remote& remote, std::chrono::milliseconds limit = 1ms) const {
    try {
      return remote.health(limit) ? "an answer" : remote.silence();
    } catch (const std::runtime_error& error) {
      return error.what();
    }
  }
};

TEST_F(RemoteTest, AsksOverTheSocket) {
  const Daemon slamd(socket);
  Remote remote(socket, url);
  const auto ack = remote.ask("save", "kitchen", {1.0, 2.0, 3.0}, 10s);
  ASSERT_TRUE(ack);
  EXPECT_TRUE(ack->accepted);
  EXPECT_EQ(ack->message, "save kitchen 2.000000");
  ASSERT_EQ(ack->parts.size(), 1U);
  EXPECT_EQ(ack->parts[0].id, "saved");
  EXPECT_THAT(ack->parts[0].texts, testing::ElementsAre("kitchen"));
  const auto other = remote.ask("load", "kitchen", {}, 10s);
  ASSERT_TRUE(other);
  EXPECT_THAT(other->parts, testing::IsEmpty()) << "they are of another answer";
  ASSERT_TRUE(remote.health(10s));
  EXPECT_THAT(remote.health(10s)->summary, HasSubstr("message"));
}

TEST_F(RemoteTest, FindsASlamdThatWasStartedAgain) {
  Remote remote(socket, url);
  for (int i = 0; i < 3; ++i) {
    EXPECT_THAT(wordsOf(remote), HasSubstr("there is no " + socket + ": slamd does not run"));
    const Daemon slamd(socket);
    EXPECT_TRUE(remote.health(10s));
  }
}

TEST_F(RemoteTest, ReportsWhatToLookAtWhereNobodyAnswers) {
  {
    LocalSocket killed(socket);
    killed.tend(monotonicNow());
    Remote remote(socket, url);
    EXPECT_THAT(wordsOf(remote), HasSubstr("no answer on " + socket + ": slamd hangs"));
    std::filesystem::create_hard_link(socket, folder / "left");
  }
  Remote stale(folder / "left", url);
  EXPECT_THAT(wordsOf(stale), HasSubstr("left: slamd has ended"));
  Remote lcm("", url);
  EXPECT_THAT(wordsOf(lcm), testing::AllOf(HasSubstr(url), testing::Not(HasSubstr("socket:"))));
  const Daemon slamd(socket);
  Remote remote(socket, url);
  EXPECT_FALSE(remote.ask("be_silent", "", {}, 50ms));
  EXPECT_THAT(remote.silence(), HasSubstr("no answer on " + socket));
}

TEST(SocketOf, IsTheConfiguredOneOrTheServicesForItsOwnFile) {
  Config config;
  EXPECT_EQ(socketOf(config, kServiceConfig), "/run/slamd/socket");
  EXPECT_EQ(socketOf(config, "robot.toml"), "") << "not of the service, who may run beside";
  config.runtime.socket = "here";
  EXPECT_EQ(socketOf(config, kServiceConfig), "here");
  EXPECT_EQ(socketOf(config, "robot.toml"), "here");
}

}  // namespace
}  // namespace slam::remote_test
