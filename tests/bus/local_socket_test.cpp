// SPDX-License-Identifier: BSD-3-Clause
#include "bus/local_socket.hpp"

#include <algorithm>
#include <filesystem>
#include <gmock/gmock.h>
#include <grp.h>
#include <gtest/gtest.h>
#include <map>
#include <memory>
#include <numeric>
#include <poll.h>
#include <random>
#include <sys/resource.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <thread>

#include "bus/local_client.hpp"
#include "bus/packets.hpp"
#include "tools/files.hpp"

namespace slam::local_socket_test {
namespace {

using namespace std::chrono_literals;
using Bytes = std::span<const std::uint8_t>;
using testing::HasSubstr;

constexpr auto kSoon = 1000ms;  // for what is there already
constexpr auto kNone = 0ms;

std::vector<std::uint8_t> bytesOf(const std::string& text) { return {text.begin(), text.end()}; }
std::string textOf(Bytes data) { return {data.begin(), data.end()}; }

class LocalSocketTest : public testing::Test {
 protected:
  LocalSocketTest() { server = make(); }
  std::unique_ptr<LocalSocket> make() {
    auto made = std::make_unique<LocalSocket>(path);
    made->subscribe("SAY", [this, at = made.get()](LocalSocket::Client from, Bytes message) {
      said[from].push_back(textOf(message));
      at->send(from, "HEARD", message);
    });
    made->tend(now);
    return made;
  }
  void tendAfter(Duration time, LocalSocket& socket) {
    now += time;
    socket.tend(now);
  }
  std::unique_ptr<LocalClient> connected() {
    auto client = std::make_unique<LocalClient>();
    EXPECT_EQ(client->open(path), 0);
    server->receive();
    return client;
  }
  /// The next message that the client gets, as CHANNEL:text.
  static std::string next(LocalClient& client, std::chrono::milliseconds wait = kSoon) {
    const auto datagram = client.next(wait);
    const Packet packet = datagram ? parsePacket(*datagram) : Packet{};
    return datagram ? std::string(packet.channel) + ":" + textOf(packet.data) : "";
  }
  /// A socket of the test's own on the path. @param kind SOCK_SEQPACKET, SOCK_STREAM
  int bindOther(int kind, bool listens) const {
    sockaddr_un address{};
    EXPECT_TRUE(toAddress(path, address));
    const int other = socket(AF_UNIX, kind | SOCK_CLOEXEC, 0);
    EXPECT_EQ(bind(other, reinterpret_cast<const sockaddr*>(&address), sizeof address), 0);
    EXPECT_TRUE(!listens || listen(other, 4) == 0);
    return other;
  }

  const test::Folder folder;
  const std::string path = folder / "socket";
  Timestamp now{};
  std::map<LocalSocket::Client, std::vector<std::string>> said;
  std::unique_ptr<LocalSocket> server;
};

TEST_F(LocalSocketTest, OutlivesWhateverAClientSends) {
  const auto hostile = connected(), good = connected();
  sockaddr_un address{};
  ASSERT_TRUE(toAddress(path, address));
  const int raw = socket(AF_UNIX, SOCK_SEQPACKET | SOCK_CLOEXEC, 0);
  ASSERT_EQ(connect(raw, reinterpret_cast<const sockaddr*>(&address), sizeof address), 0);
  std::mt19937 random(1);
  std::uint64_t bad = 0;
  for (int i = 0; i < 300; ++i) {
    std::vector<std::uint8_t> packet(1 + random() % 400);
    for (std::uint8_t& byte : packet) byte = static_cast<std::uint8_t>(random());
    const std::string magic = i % 3 == 0 ? "LC02" : i % 3 == 1 ? "LC03" : "";
    std::copy_n(magic.begin(), std::min(magic.size(), packet.size()), packet.begin());
    bad += parsePacket(packet).kind != Packet::kMessage;
    ASSERT_EQ(send(raw, packet.data(), packet.size(), 0), static_cast<ssize_t>(packet.size()));
    server->receive();
  }
  const auto deadly = test::deadlyFragment("SAY");
  ASSERT_GT(send(raw, deadly.data(), deadly.size(), 0), 0);
  const std::vector<std::uint8_t> huge(100000, 0x41);  // more than any message
  ASSERT_EQ(send(raw, huge.data(), huge.size(), 0), static_cast<ssize_t>(huge.size()));
  const auto last = test::packetOf("SAY", bytesOf("well"));
  ASSERT_GT(send(raw, last.data(), last.size(), 0), 0);
  server->receive();
  EXPECT_EQ(server->counts().bad, bad + 2);
  EXPECT_EQ(server->clients(), 3U);
  EXPECT_THAT(said[3], testing::ElementsAre("well")) << "good bytes behind any damage are read";
  ::close(raw);
  server->receive();
  EXPECT_EQ(server->clients(), 2U);
  EXPECT_TRUE(good->send("SAY", bytesOf("still")));
  server->receive();
  EXPECT_EQ(next(*good), "HEARD:still");
}

TEST_F(LocalSocketTest, DropsWhoDoesNotReadAndServesTheOthers) {
  const auto deaf = connected(), good = connected();
  const std::vector<std::uint8_t> message(20000, 0x42);
  int sent = 0;
  for (; sent < 1000 && server->counts().dropped == 0; ++sent) {
    server->sendAll("NEWS", message);
    ASSERT_TRUE(good->next(kSoon)) << sent;
  }
  EXPECT_GT(sent, 3);
  EXPECT_EQ(server->clients(), 1U);
  server->sendAll("NEWS", bytesOf("more"));
  EXPECT_EQ(next(*good), "NEWS:more");
  int left = 0;
  while (deaf->next(kNone)) ++left;
  EXPECT_EQ(left, sent - 1);
  EXPECT_FALSE(deaf->isOpen()) << "it learns that it has been dropped";
}

TEST_F(LocalSocketTest, AnswersTheOneThatAsked) {
  const auto first = connected(), second = connected();
  EXPECT_TRUE(second->send("SAY", bytesOf("hello")));
  EXPECT_TRUE(second->send("ELSE", bytesOf("nobody takes this")));
  server->receive();
  EXPECT_THAT(said, testing::ElementsAre(testing::Pair(2, testing::ElementsAre("hello"))));
  EXPECT_EQ(next(*second), "HEARD:hello");
  EXPECT_EQ(next(*first, kNone), "");
  server->sendAll("NEWS", bytesOf("all"));
  EXPECT_EQ(next(*first), "NEWS:all");
  EXPECT_EQ(next(*second), "NEWS:all");
  EXPECT_FALSE(server->send(3, "HEARD", bytesOf("nobody")));
}

TEST_F(LocalSocketTest, DoesNotAnswerANewClientInPlaceOfOneThatLeft) {
  connected()->send("SAY", bytesOf("gone at once"));
  server->receive();
  const auto another = connected();
  EXPECT_FALSE(server->send(1, "HEARD", bytesOf("late")));
  EXPECT_EQ(next(*another, kNone), "");
}

TEST_F(LocalSocketTest, GivesEachItsTurn) {
  const auto busy = connected(), other = connected();
  int flood = 0;
  while (busy->send("NOISE", bytesOf("x")) && ++flood < 1000) {
  }
  ASSERT_TRUE(other->send("SAY", bytesOf("me, too")));
  server->receive();
  EXPECT_EQ(said[2].size(), 1U) << flood << " packets before it";
}

TEST_F(LocalSocketTest, GivesThePlaceOfWhoIsSilentToANewClient) {
  std::vector<std::unique_ptr<LocalClient>> clients;
  for (std::size_t i = 0; i < LocalSocket::kMostClients; ++i) clients.push_back(connected());
  EXPECT_EQ(server->clients(), LocalSocket::kMostClients);
  EXPECT_EQ(server->counts().refused, 0U);
  ASSERT_TRUE(clients[0]->send("SAY", bytesOf("waits for its answer")));
  server->receive();
  EXPECT_EQ(next(*clients[0]), "HEARD:waits for its answer");
  std::vector<std::unique_ptr<LocalClient>> late;
  for (std::size_t i = 1; i < LocalSocket::kMostClients; ++i) {
    late.push_back(connected());
    EXPECT_EQ(server->counts().refused, i);
    EXPECT_FALSE(clients[i]->next(kSoon));
    EXPECT_FALSE(clients[i]->isOpen()) << "the oldest of the silent ones";
    ASSERT_TRUE(late.back()->send("SAY", bytesOf("in")));
    server->receive();
    EXPECT_EQ(next(*late.back()), "HEARD:in");
  }
  EXPECT_FALSE(clients[0]->next(kNone));
  EXPECT_TRUE(clients[0]->isOpen()) << "it has asked for something";
  const auto one_more = connected();
  EXPECT_FALSE(clients[0]->next(kSoon));
  EXPECT_FALSE(clients[0]->isOpen()) << "and been silent for longest";
  EXPECT_EQ(server->clients(), LocalSocket::kMostClients);
}

TEST_F(LocalSocketTest, IsOpenToOwnerAndGroupWhateverTheUmask) {
  for (const mode_t mask : {0000, 0022, 0077, 0777}) {
    server.reset();
    const mode_t before = umask(mask);
    server = make();
    umask(before);
    struct stat file {};
    ASSERT_EQ(stat(path.c_str(), &file), 0) << server->problem().words();
    EXPECT_TRUE(S_ISSOCK(file.st_mode));
    EXPECT_EQ(file.st_mode & 07777, 0660) << mask;
    const group* members = getgrnam(LocalClient::kGroup);
    const bool may_give = members != nullptr && geteuid() == 0;
    EXPECT_EQ(file.st_gid, may_give ? members->gr_gid : getegid());
  }
}

TEST_F(LocalSocketTest, TakesThePlaceOfOneThatWasKilled) {
  server.reset();
  ::close(bindOther(SOCK_SEQPACKET, true));
  ASSERT_TRUE(std::filesystem::exists(path));
  server = make();
  EXPECT_FALSE(server->problem());
  EXPECT_EQ(server->clients(), 0U);
  connected();
}

TEST_F(LocalSocketTest, LeavesAnotherProgramsSocketUntilThatEnds) {
  for (const int kind : {SOCK_SEQPACKET, SOCK_STREAM}) {
    server.reset();
    const int other = bindOther(kind, true);
    server = make();
    EXPECT_THAT(server->problem().words(), testing::StartsWith(path + ": another program listens there"));
    EXPECT_THAT(server->problem().words(), HasSubstr("; slamd takes no commands there and tries again; fix: stop it"));
    tendAfter(2s, *server);
    EXPECT_TRUE(server->problem());
    EXPECT_EQ(LocalClient::probe(path), kind == SOCK_STREAM ? EPROTOTYPE : 0) << "the other's still works";
    ::close(other);
    EXPECT_TRUE(server->problem());
    tendAfter(2s, *server);
    EXPECT_FALSE(server->problem());
    connected();
  }
}

TEST_F(LocalSocketTest, LeavesTheSocketOfAnotherSlamdAtItsEnd) {
  LocalSocket second(path);
  second.tend(now);
  EXPECT_THAT(second.problem().words(), HasSubstr("a second slamd"));
  {
    LocalSocket third(path);
    third.tend(now);
  }
  connected();
  server.reset();
  EXPECT_FALSE(std::filesystem::exists(path));
  tendAfter(2s, second);
  EXPECT_FALSE(second.problem());
  EXPECT_TRUE(std::filesystem::exists(path));
}

TEST_F(LocalSocketTest, LeavesWhatIsNoSocket) {
  server.reset();
  folder.write("socket", "of great value");
  server = make();
  EXPECT_THAT(server->problem().words(), HasSubstr("there is a file that is no socket"));
  EXPECT_THAT(server->problem().words(), HasSubstr("; fix: remove it"));
  server.reset();
  EXPECT_EQ(test::contentOf(path), "of great value");
  std::filesystem::remove(path);
  std::filesystem::create_symlink(folder / "nowhere", path);
  server = make();
  EXPECT_THAT(server->problem().words(), HasSubstr("there is a file that is no socket"));
}

TEST_F(LocalSocketTest, ComesBackWhereItsFileWasRemovedOrReplaced) {
  const auto before = connected();
  std::filesystem::remove(path);
  tendAfter(500ms, *server);
  EXPECT_EQ(LocalClient::probe(path), ENOENT) << "it looks once a second";
  tendAfter(2s, *server);
  connected();
  EXPECT_TRUE(before->send("SAY", bytesOf("I stay")));
  server->receive();
  EXPECT_EQ(next(*before), "HEARD:I stay");

  std::filesystem::remove(path);
  const int other = bindOther(SOCK_SEQPACKET, true);
  tendAfter(2s, *server);
  EXPECT_THAT(server->problem().words(), HasSubstr("another program listens there"));
  server.reset();
  EXPECT_EQ(LocalClient::probe(path), 0) << "the other's file is not removed";
  ::close(other);
}

TEST_F(LocalSocketTest, WaitsForItsFolder) {
  LocalSocket early(folder / "later/socket");
  early.tend(now);
  EXPECT_THAT(early.problem().words(), HasSubstr("No such file or directory"));
  EXPECT_THAT(early.problem().words(), HasSubstr("make the folder " + (folder / "later/").string() + ", writable"));
  std::filesystem::create_directory(folder / "later");
  tendAfter(2s, early);
  EXPECT_FALSE(early.problem());
  EXPECT_EQ(LocalClient::probe(folder / "later/socket"), 0);
}

TEST_F(LocalSocketTest, RefusesALongPathInWords) {
  const std::string room(LocalSocket::kLongestPath - path.size() - 1, 'x');
  LocalSocket fits(path + room + "1"), longer(path + room + "12");
  fits.tend(now);
  longer.tend(now);
  EXPECT_FALSE(fits.problem());
  EXPECT_THAT(longer.problem().words(), HasSubstr("longer than a socket's path may be"));
}

TEST_F(LocalSocketTest, WaitsInPeaceWithoutDescriptors) {
  rlimit before{};
  getrlimit(RLIMIT_NOFILE, &before);
  LocalClient client;
  ASSERT_EQ(client.open(path), 0);  // nobody has taken it in yet
  const int next_free = dup(0);
  ::close(next_free);
  const rlimit none{static_cast<rlim_t>(next_free), before.rlim_max};
  setrlimit(RLIMIT_NOFILE, &none);
  server->receive();
  const LocalSocket::Counts counts = server->counts();
  for (int i = 0; i < 3; ++i) server->receive();
  pollfd waiting{server->descriptor(), POLLIN, 0};
  const int ready = ::poll(&waiting, 1, 0);
  setrlimit(RLIMIT_NOFILE, &before);
  EXPECT_EQ(ready, 0) << "the loop would spin";
  EXPECT_EQ(counts.refused, 0U);
  tendAfter(2s, *server);
  server->receive();
  EXPECT_EQ(server->clients(), 1U);
}

TEST_F(LocalSocketTest, DoesNothingWithoutAPath) {
  LocalSocket none("");
  none.tend(now);
  none.receive();
  none.sendAll("NEWS", {});
  EXPECT_EQ(none.descriptor(), -1);
  EXPECT_FALSE(none.problem());
}

}  // namespace
}  // namespace slam::local_socket_test
