// SPDX-License-Identifier: BSD-3-Clause
#include "tools/web/foxglove/foxglove_hub.hpp"

#include <algorithm>
#include <array>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>
#include <sys/socket.h>
#include <unistd.h>

#include "bus/messages.hpp"
#include "runtime/clock.hpp"
#include "support/wait_until.hpp"
#include "tools/web/foxglove/client_frames.hpp"
#include "tools/web/foxglove/foxglove_session.hpp"
#include "tools/web/map_tiles.hpp"

namespace slam::foxglove_hub_test {
namespace {

using namespace std::chrono_literals;
using nlohmann::json;
using test::waitUntil;

/// A client whose handshake is done.
class Client {
 public:
  Client(FoxgloveHub& hub, const std::string& address, std::string_view received = "") {
    std::array<int, 2> ends{};
    EXPECT_EQ(::socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0, ends.data()), 0);
    socket_ = ends[1];
    hub.add(ends[0], address, received);
  }
  ~Client() { ::close(socket_); }
  Client(const Client&) = delete;
  Client& operator=(const Client&) = delete;

  void send(const std::string& text) const {
    const std::string frame = test::clientFrame(test::kText, text);
    EXPECT_EQ(::send(socket_, frame.data(), frame.size(), MSG_NOSIGNAL), static_cast<ssize_t>(frame.size()));
  }
  void subscribe(FoxgloveTopic topic) const {
    send(
        json{{"op", "subscribe"}, {"subscriptions", json::array({{{"id", 1}, {"channelId", static_cast<int>(topic)}}})}}
            .dump());
  }
  /// Reads what is there. @return whether the other side has ended the connection
  bool read() {
    std::array<char, 65536> part;
    ssize_t got = 0;
    while ((got = ::recv(socket_, part.data(), part.size(), MSG_DONTWAIT)) > 0)
      bytes_.append(part.data(), static_cast<std::size_t>(got));
    return got == 0;
  }
  std::vector<test::Frame> messages() {
    read();
    return test::messagesOf(test::framesOf(bytes_));
  }

 private:
  int socket_ = -1;
  std::string bytes_;
};

class FoxgloveHubTest : public testing::Test {
 protected:
  void build(const FoxgloveLimits& limits) { hub_ = std::make_unique<FoxgloveHub>(shared_, Config{}, "9", limits); }
  FoxgloveHubTest() { build({}); }

  SharedState shared_{Config{}};
  std::unique_ptr<FoxgloveHub> hub_;
};

pose_estimate_t poseAt(double x) {
  PoseEstimate estimate;
  estimate.T_map_base = {x, 0.0, 0.0};
  return toMessage(estimate, 1'700'000'000'000'000, 1);
}

TEST_F(FoxgloveHubTest, SendsWhatIsSubscribedToAlone) {
  Client client(*hub_, "a");
  ASSERT_TRUE(waitUntil([&] { return client.messages().size() == 2; }));
  EXPECT_EQ(json::parse(client.messages()[0].payload)["op"], "serverInfo");
  EXPECT_EQ(json::parse(client.messages()[1].payload)["op"], "advertise");
  EXPECT_FALSE(hub_->isWatched());
  client.subscribe(FoxgloveTopic::kPose);
  ASSERT_TRUE(waitUntil([&] { return hub_->isWatched(); }));
  hub_->take(poseAt(1.5));
  ASSERT_TRUE(waitUntil([&] { return client.messages().size() == 3; }));
  const std::string message = client.messages()[2].payload;
  EXPECT_EQ(message.substr(0, 5), std::string("\x01\x01\0\0\0", 5));
  EXPECT_EQ(json::parse(message.substr(13))["pose"]["position"]["x"], 1.5);
}

TEST_F(FoxgloveHubTest, TakesWhatCameBehindTheHandshake) {
  Client client(*hub_, "a",
                test::clientFrame(test::kText, R"({"op":"subscribe","subscriptions":[{"id":1,"channelId":2}]})"));
  EXPECT_TRUE(waitUntil([&] { return hub_->isWatched(); }));
}

TEST_F(FoxgloveHubTest, DrawsTheMapForEachWhoSubscribes) {
  map_meta_t meta{};
  meta.map_id = 1;
  meta.utime = 5'000'000;
  meta.resolution = 0.05;
  shared_.state.take(meta, monotonicNow());
  map_tile_t tile = test::tileAt(1, 0, 0);
  std::fill(tile.cells.begin(), tile.cells.end(), 95);
  shared_.state.take(MapLayer::kBoth, tile, monotonicNow());
  for (int i = 0; i < 2; ++i) {
    Client client(*hub_, "a");
    client.subscribe(FoxgloveTopic::kMap);
    ASSERT_TRUE(waitUntil([&] { return client.messages().size() == 3; }));
    const json grid = json::parse(client.messages()[2].payload.substr(13));
    EXPECT_EQ(grid["column_count"], TileStore::kSide);
    EXPECT_EQ(grid["timestamp"]["sec"], 5);
    EXPECT_EQ(grid["data"].get<std::string>().substr(0, 4), "ZGRk");  // occupied
  }
}

TEST_F(FoxgloveHubTest, SendsALargeMapCoarser) {
  build({.most_cells = TileStore::kSide * TileStore::kSide / 4});
  map_meta_t meta{};
  meta.map_id = 1;
  meta.resolution = 0.05;
  shared_.state.take(meta, monotonicNow());
  map_tile_t tile = test::tileAt(1, 0, 0);
  std::fill(tile.cells.begin(), tile.cells.end(), 0);
  tile.cells[1] = 95;  // one wall among four free cells
  shared_.state.take(MapLayer::kBoth, tile, monotonicNow());
  Client client(*hub_, "a");
  client.subscribe(FoxgloveTopic::kMap);
  ASSERT_TRUE(waitUntil([&] { return client.messages().size() == 3; }));
  const json grid = json::parse(client.messages()[2].payload.substr(13));
  EXPECT_EQ(grid["column_count"], TileStore::kSide / 2);
  EXPECT_DOUBLE_EQ(grid["cell_size"]["x"], 0.1);
  EXPECT_EQ(grid["data"].get<std::string>().substr(0, 4), "ZAAA");  // occupied, free, free
}

TEST_F(FoxgloveHubTest, DropsForWhoDoesNotReadAndLetsGo) {
  build({.most_unsent = 20'000, .patience = 200ms});
  Client client(*hub_, "a");
  client.subscribe(FoxgloveTopic::kPose);
  ASSERT_TRUE(waitUntil([&] { return hub_->isWatched(); }));
  EXPECT_TRUE(waitUntil([&] {
    for (int i = 0; i < 100; ++i) hub_->take(poseAt(1.0));
    return shared_.foxglove.ended_clients == 1;
  }));
  EXPECT_GT(shared_.foxglove.dropped_messages, 0U);
  EXPECT_TRUE(waitUntil([&] { return shared_.foxglove.clients == 0; }));
}

TEST_F(FoxgloveHubTest, MakesPlaceOfTheAddressThatHasMost) {
  build({.most = 2});
  Client first(*hub_, "a"), second(*hub_, "b"), third(*hub_, "b");
  EXPECT_TRUE(waitUntil([&] { return second.read(); }));
  EXPECT_FALSE(first.read());
  EXPECT_FALSE(third.read());
}

TEST_F(FoxgloveHubTest, EndsWithWhoSendsTooMuchThatIsWrong) {
  Client client(*hub_, "a");
  for (int i = 0; i <= FoxgloveSession::kMostFaults; ++i) client.send("?");
  EXPECT_TRUE(waitUntil([&] { return client.read(); }));
  EXPECT_EQ(shared_.foxglove.ended_clients, 1U);
}

}  // namespace
}  // namespace slam::foxglove_hub_test
