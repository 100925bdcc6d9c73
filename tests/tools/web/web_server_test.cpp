// SPDX-License-Identifier: BSD-3-Clause
#include "tools/web/web_server.hpp"

#include <algorithm>
#include <arpa/inet.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <netinet/in.h>
#include <poll.h>
#include <random>
#include <sys/socket.h>
#include <thread>
#include <unistd.h>

#include "bus/messages.hpp"
#include "runtime/clock.hpp"
#include "runtime/process_usage.hpp"
#include "support/wait_until.hpp"
#include "tools/files.hpp"
#include "tools/web/map_tiles.hpp"

namespace slam::web_server_test {
namespace {

using namespace std::chrono_literals;
using test::waitUntil;
using testing::AnyOf;
using testing::HasSubstr;
using testing::StartsWith;

/// A connection of somebody who may send anything.
class Client {
 public:
  explicit Client(int port) : socket_(::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0)) {
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_port = htons(static_cast<std::uint16_t>(port));
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    const timeval limit{.tv_sec = 5, .tv_usec = 0};
    setsockopt(socket_, SOL_SOCKET, SO_SNDTIMEO, &limit, sizeof limit);
    connected_ = ::connect(socket_, reinterpret_cast<sockaddr*>(&address), sizeof address) == 0;
  }
  ~Client() { ::close(socket_); }
  Client(const Client&) = delete;
  Client& operator=(const Client&) = delete;

  bool isConnected() const { return connected_; }
  /// @return false where the other side has ended the connection
  bool say(const std::string& text) const {
    return ::send(socket_, text.data(), text.size(), MSG_NOSIGNAL) == static_cast<ssize_t>(text.size());
  }
  void endRequest() const { ::shutdown(socket_, SHUT_WR); }
  /// All until the end of the connection, or until `enough` is in it, where that is not empty.
  std::string hear(const std::string& enough = "", std::chrono::milliseconds limit = 20s) const {
    std::string text;
    const auto end = std::chrono::steady_clock::now() + limit;
    while (enough.empty() || text.find(enough) == std::string::npos) {
      pollfd waiting{socket_, POLLIN, 0};
      const auto left = std::chrono::duration_cast<std::chrono::milliseconds>(end - std::chrono::steady_clock::now());
      if (left <= 0ms || ::poll(&waiting, 1, static_cast<int>(left.count())) <= 0) return text + "[no end]";
      char part[65536];
      const ssize_t got = ::recv(socket_, part, sizeof part, 0);
      if (got <= 0) return text;
      text.append(part, static_cast<std::size_t>(got));
    }
    return text;
  }

 private:
  int socket_;
  bool connected_ = false;
};

class Server : public testing::Test {
 protected:
  Server() {
    settings_.web.port = 0;
    settings_.web.token = kToken;
    limits_.request = 300ms;
    limits_.answer = 300ms;
    std::filesystem::create_directories(files_ / "logs/run");
    settings_.logs = files_ / "logs";
  }
  ~Server() override { stop(); }
  void start() {
    pages_.emplace(
        settings_, shared_,
        [this](const WebCommand& command) {
          commands_.push_back(command);
          ack_t ack{};
          ack.accepted = true;
          ack.message = "done";
          return std::optional(ack);
        },
        [this](const DriveRequest& request) {
          drives_.push_back(request);
          return Problem();
        });
    server_.emplace(*pages_, shared_, feed_, Hubs{hub_, foxglove_}, limits_, std::move(tls_));
    thread_ = std::thread([this] { server_->run(); });
  }
  void stop() {
    if (!server_) return;
    server_->stop();
    if (thread_.joinable()) thread_.join();
    server_.reset();
  }
  /// The whole answer to these bytes.
  std::string answerTo(const std::string& bytes, bool ends = true) {
    const Client client(server_->port());
    client.say(bytes);
    if (ends) client.endRequest();
    return client.hear();
  }
  std::string get(const std::string& path, const std::string& headers = "Host: localhost\r\n") {
    return answerTo("GET " + path + " HTTP/1.1\r\n" + headers + "\r\n");
  }
  std::string post(const std::string& body, const std::string& token, const std::string& path = "/api/command") {
    return answerTo("POST " + path + " HTTP/1.1\r\nHost: localhost\r\nContent-Type: application/json\r\n" +
                    (token.empty() ? "" : "Authorization: Bearer " + token + "\r\n") +
                    "Content-Length: " + std::to_string(body.size()) + "\r\n\r\n" + body);
  }

  static constexpr const char* kToken = "correct-horse-battery";
  test::Folder files_;
  WebPages::Settings settings_;
  HttpConnection::Limits limits_;
  SharedState shared_{Config{}};
  EventFeed feed_{1, false, "1.2.3"};
  EventHub hub_;
  TlsContext tls_;
  FoxgloveHub foxglove_{shared_, Config{}, "1"};
  std::vector<WebCommand> commands_;
  std::vector<DriveRequest> drives_;
  std::optional<WebPages> pages_;
  std::optional<WebServer> server_;
  std::thread thread_;
};

TEST_F(Server, AnswersWithThePageAndItsHeaders) {
  start();
  const std::string answer = get("/");
  EXPECT_THAT(answer, StartsWith("HTTP/1.1 200"));
  EXPECT_THAT(answer, HasSubstr("Content-Security-Policy: default-src 'none'"));
  EXPECT_THAT(answer, HasSubstr("<canvas"));
  EXPECT_THAT(answerTo("HEAD / HTTP/1.1\r\nHost: localhost\r\n\r\n"), testing::Not(HasSubstr("<canvas")));
}

TEST_F(Server, CompressesThePageForWhoTakesGzip) {
  start();
  const std::string plain = get("/page.js"), gzip = get("/page.js", "Host: localhost\r\nAccept-Encoding: br, gzip\r\n");
  EXPECT_THAT(gzip, HasSubstr("Content-Encoding: gzip"));
  EXPECT_LT(gzip.size(), plain.size() / 2);
  EXPECT_THAT(plain, testing::Not(HasSubstr("Content-Encoding")));
  const std::string status = get("/api/v1/status", "Host: localhost\r\nAccept-Encoding: gzip\r\n");
  EXPECT_THAT(status, testing::Not(HasSubstr("Content-Encoding")));
}

TEST_F(Server, IsServedByTls) {
  settings_.web.tls = true;
  settings_.web.commands = true;
  tls_ = tlsContextOf(settings_.web, files_ / "state", {"localhost"});
  start();
  httplib::SSLClient client("localhost", server_->port());
  client.set_ca_cert_path((files_ / "state/certificate.pem").c_str());
  const auto page = client.Get("/");
  ASSERT_TRUE(page) << httplib::to_string(page.error());
  EXPECT_EQ(page->status, 200);
  EXPECT_THAT(page->body, HasSubstr("<canvas"));
  const auto allowed = client.Get("/api/v1/allowed", {{"Authorization", std::string("Bearer ") + kToken}});
  ASSERT_TRUE(allowed);
  EXPECT_THAT(allowed->get_header_value("Set-Cookie"), HasSubstr("; Secure"));
  const std::string plain = get("/api/v1/status?x=1");
  EXPECT_THAT(plain, StartsWith("HTTP/1.1 308"));
  EXPECT_THAT(plain, HasSubstr("Location: https://localhost/api/v1/status?x=1\r\n"));
  EXPECT_THAT(get("/", "Host: stranger.example\r\n"), StartsWith("HTTP/1.1 421"));
}

TEST_F(Server, ListensWhereItIsConfigured) {
  settings_.web.address = "127.0.0.2";
  start();
  EXPECT_GT(server_->port(), 0);
  EXPECT_FALSE(Client(server_->port()).isConnected()) << "127.0.0.1 is another address";
  WebPages::Settings taken = settings_;
  taken.web.port = server_->port();
  const WebPages pages(taken, shared_, nullptr);
  const std::string words = test::refusalOf([&] { WebServer(pages, shared_, feed_, {hub_, foxglove_}); });
  EXPECT_THAT(words, HasSubstr("127.0.0.2:" + std::to_string(server_->port())));
  EXPECT_THAT(words, HasSubstr("web.port"));
}

TEST_F(Server, TakesConnectionsOfManyAtTheSameMoment) {
  pages_.emplace(settings_, shared_, nullptr);
  server_.emplace(*pages_, shared_, feed_, Hubs{hub_, foxglove_}, limits_, std::move(tls_));
  std::vector<std::unique_ptr<Client>> clients;  // as ten pages that ask for the tile that has just changed
  for (std::size_t i = 0; i < WebServer::kMostWaiting; ++i) {
    clients.push_back(std::make_unique<Client>(server_->port()));
    ASSERT_TRUE(clients.back()->isConnected()) << i << " before anybody accepts";
  }
  thread_ = std::thread([this] { server_->run(); });
  clients.front()->say("GET / HTTP/1.1\r\nHost: localhost\r\n\r\n");
  EXPECT_THAT(clients.front()->hear(), StartsWith("HTTP/1.1 200"));
}

TEST_F(Server, StopsAtOnceAlsoBeforeItRuns) {
  for (int i = 0; i < 20; ++i) {
    start();
    stop();
  }
}

TEST_F(Server, ObeysOnlyWhereCommandsAreAllowed) {
  start();
  EXPECT_THAT(post(R"({"verb":"save"})", kToken), StartsWith("HTTP/1.1 403"));
  EXPECT_TRUE(commands_.empty());
}

TEST_F(Server, ObeysOnlyWhoHasTheToken) {
  settings_.web.commands = true;
  start();
  EXPECT_THAT(post(R"({"verb":"save"})", ""), StartsWith("HTTP/1.1 401"));
  EXPECT_THAT(post(R"({"verb":"save"})", "a-guess"), StartsWith("HTTP/1.1 401"));
  EXPECT_TRUE(commands_.empty());
  EXPECT_THAT(post(R"({"verb":"save"})", kToken), StartsWith("HTTP/1.1 200"));
  ASSERT_EQ(commands_.size(), 1U);
  EXPECT_EQ(commands_[0].verb, "save");
}

TEST_F(Server, DrivesForWhoHasTheToken) {
  const std::string ahead = R"({"vx":0.3,"omega":0.1,"hold":7})";
  settings_.web.commands = settings_.drives = true;
  start();
  for (const char* path : {"/api/drive", "/api/v1/drive"}) {
    EXPECT_THAT(post(ahead, "", path), StartsWith("HTTP/1.1 401"));
    EXPECT_THAT(post(ahead, "a-guess", path), StartsWith("HTTP/1.1 401"));
    EXPECT_TRUE(drives_.empty());
    EXPECT_THAT(post(ahead, kToken, path), StartsWith("HTTP/1.1 200"));
    ASSERT_EQ(drives_.size(), 1U);
    EXPECT_EQ(drives_[0].twist.vx, 0.3);
    drives_.clear();
  }
  EXPECT_THAT(post(R"({"vx":1e300,"omega":0,"hold":7})", kToken, "/api/drive"), StartsWith("HTTP/1.1 400"));
  EXPECT_TRUE(drives_.empty());
}

TEST_F(Server, IsReadWithTheTokenAlone) {
  settings_.web.read = WebReaders::kToken;
  start();
  for (const char* path : {"/", "/page.js", "/page.css", "/manifest.webmanifest"})
    EXPECT_THAT(get(path), StartsWith("HTTP/1.1 200")) << path << " asks for the token";
  for (const char* path :
       {"/api/status", "/api/v1/status", "/api/events", "/api/map", "/api/maps", "/api/logs", "/logs/",
        "/logs/run/0001.lcm", "/map.png", "/api/v1/map.png", "/map.yaml", "/metrics", "/nothing"})
    EXPECT_THAT(get(path), StartsWith("HTTP/1.1 401")) << path;
  const std::string with = "Host: localhost\r\nAuthorization: Bearer " + std::string(kToken) + "\r\n";
  EXPECT_THAT(get("/api/status", with), StartsWith("HTTP/1.1 200"));
  const std::string unlocked = get("/api/allowed", with);
  EXPECT_THAT(unlocked, StartsWith("HTTP/1.1 200"));
  const auto cookie = unlocked.find("slamd-read=");
  ASSERT_NE(cookie, std::string::npos);
  EXPECT_THAT(get("/metrics", "Host: localhost\r\nCookie: " +
                                  unlocked.substr(cookie, unlocked.find(';', cookie) - cookie) + "\r\n"),
              StartsWith("HTTP/1.1 200"));
}

TEST_F(Server, SlowsDownWhoGuessesTheToken) {
  settings_.web.commands = true;
  start();
  std::string last;
  for (int i = 0; i < 8; ++i) last = post(R"({"verb":"save"})", "guess-" + std::to_string(i));
  EXPECT_THAT(last, StartsWith("HTTP/1.1 429"));
  EXPECT_THAT(last, HasSubstr("Retry-After: "));
  EXPECT_THAT(get("/"), StartsWith("HTTP/1.1 200")) << "it may look on";
  EXPECT_TRUE(commands_.empty());
}

TEST_F(Server, RefusesAnotherHostsNameForEveryPath) {
  start();
  for (const char* path : {"/", "/api/map", "/api/events", "/logs/", "/nothing"})
    EXPECT_THAT(get(path, "Host: evil.example\r\n"), StartsWith("HTTP/1.1 421")) << path;
  EXPECT_THAT(answerTo("POST /api/command HTTP/1.1\r\nHost: evil.example\r\nContent-Length: 2\r\n\r\n{}"),
              StartsWith("HTTP/1.1 421"));
  EXPECT_THAT(get("/", ""), StartsWith("HTTP/1.1 400"));
}

TEST_F(Server, LeadsOutOfTheLogsByNoPath) {
  files_.write("secret", "not yours");
  files_.write("logs/run/0001.lcm", std::string(300'000, 'r'));
  std::filesystem::create_symlink("../../secret", files_ / "logs/run/link");
  start();
  for (const char* path :
       {"/logs/../secret", "/logs/%2e%2e/secret", "/logs/..%2fsecret", "/logs/run/../../secret", "/logs/run/link",
        "/logs//etc/passwd", "/logs/%00", "/logs/run%2f0001.lcm/x", "/logs/....//secret"}) {
    EXPECT_THAT(get(path), StartsWith("HTTP/1.1 404")) << path;
  }
  const std::string log = get("/logs/run/0001.lcm");
  EXPECT_THAT(log, HasSubstr("Content-Length: 300000"));
  EXPECT_THAT(log, testing::EndsWith(std::string(1000, 'r')));
}

TEST_F(Server, RefusesWhatIsTooLong) {
  settings_.web.commands = true;
  start();
  EXPECT_THAT(get("/" + std::string(9000, 'a')), StartsWith("HTTP/1.1 414"));
  EXPECT_THAT(get("/", "Host: localhost\r\nX: " + std::string(9000, 'a') + "\r\n"),
              AnyOf("", StartsWith("HTTP/1.1 4")));
  std::string headers = "Host: localhost\r\n";
  for (int i = 0; i < 20'000; ++i) headers += "A" + std::to_string(i) + ": b\r\n";
  EXPECT_THAT(get("/", headers), AnyOf("", StartsWith("HTTP/1.1 4")));
  EXPECT_THAT(post(std::string(5000, ' '), kToken), StartsWith("HTTP/1.1 413"));
  EXPECT_THAT(
      answerTo("POST /api/command HTTP/1.1\r\nHost: localhost\r\nContent-Length: 99999999999999999999\r\n\r\n{}"),
      AnyOf("", StartsWith("HTTP/1.1 4")));
  EXPECT_TRUE(commands_.empty());
  EXPECT_THAT(get("/"), StartsWith("HTTP/1.1 200")) << "and answers on";
}

TEST_F(Server, DoesNotWaitForWhoIsSlowToAsk) {
  limits_.request = 20s;
  start();
  std::vector<std::unique_ptr<Client>> slow;
  for (int i = 0; i < 150; ++i) {
    slow.push_back(std::make_unique<Client>(server_->port()));
    slow.back()->say(i % 2 == 0 ? "GET / HT" : "POST /api/command HTTP/1.1\r\nContent-Length: 9\r\n\r\n{");
  }
  EXPECT_THAT(get("/"), StartsWith("HTTP/1.1 200"));
  EXPECT_THAT(slow.front()->hear(), StartsWith("HTTP/1.1 408")) << "the oldest makes place";
}

TEST_F(Server, EndsWhoIsSlowToReadWhereOthersWait) {
  files_.write("logs/run/0001.lcm", std::string(20'000'000, 'r'));
  limits_.answer = 20s;
  start();
  std::vector<std::unique_ptr<Client>> slow;
  for (std::size_t i = 0; i < WebServer::kThreads; ++i) {
    slow.push_back(std::make_unique<Client>(server_->port()));
    slow.back()->say("GET /logs/run/0001.lcm HTTP/1.1\r\nHost: localhost\r\n\r\n");
  }
  for (const auto& client : slow) client->hear("rrr");  // each has its thread
  EXPECT_THAT(get("/"), StartsWith("HTTP/1.1 200")) << "by the thread of one that takes nothing";
}

TEST_F(Server, RefusesRequestsThatItHasNoRoomFor) {
  files_.write("logs/run/0001.lcm", std::string(20'000'000, 'r'));
  limits_.answer = limits_.crowded = 20s;
  start();
  std::vector<std::unique_ptr<Client>> all;
  const std::size_t room = WebServer::kThreads + WebServer::kMostWaiting;
  for (std::size_t i = 0; i < room; ++i) {
    all.push_back(std::make_unique<Client>(server_->port()));
    all.back()->say("GET /logs/run/0001.lcm HTTP/1.1\r\nHost: localhost\r\n\r\n");
  }
  EXPECT_TRUE(waitUntil([&] { return get("/").starts_with("HTTP/1.1 503"); })) << "one address has three quarters";
  all.clear();
  EXPECT_TRUE(waitUntil([&] { return get("/").starts_with("HTTP/1.1 200"); })) << "and answers when they have gone";
}

TEST_F(Server, StreamsEventsToManyWithoutAThreadForEach) {
  start();
  std::vector<std::unique_ptr<Client>> readers;
  for (std::size_t i = 0; i < 10; ++i) {
    readers.push_back(std::make_unique<Client>(server_->port()));
    readers.back()->say("GET /api/events HTTP/1.1\r\nHost: localhost\r\n\r\n");
    const std::string greeting = readers.back()->hear("event: map");
    EXPECT_THAT(greeting, HasSubstr("Content-Type: text/event-stream"));
    EXPECT_THAT(greeting, HasSubstr("event: hello"));
    EXPECT_THAT(greeting, testing::Not(HasSubstr("Content-Length")));
  }
  EXPECT_TRUE(waitUntil([&] { return hub_.readers() == 10; }));
  EXPECT_THAT(get("/"), StartsWith("HTTP/1.1 200"));
  hub_.send("event: test\ndata: 7\n\n", monotonicNow());
  for (const auto& reader : readers) EXPECT_THAT(reader->hear("data: 7"), HasSubstr("event: test"));
  readers.clear();
  EXPECT_TRUE(waitUntil([&] {
    hub_.send("x", monotonicNow());
    return hub_.readers() == 0;
  }));
}

TEST_F(Server, TakesANewReaderInPlaceOfTheOldest) {
  start();
  std::vector<std::unique_ptr<Client>> readers;
  for (std::size_t i = 0; i <= EventHub::kMostReaders; ++i) {
    readers.push_back(std::make_unique<Client>(server_->port()));
    readers.back()->say("GET /api/events HTTP/1.1\r\nHost: localhost\r\n\r\n");
    EXPECT_THAT(readers.back()->hear("event: map"), HasSubstr("event: hello")) << i;
  }
  EXPECT_TRUE(waitUntil([&] { return hub_.readers() == EventHub::kMostReaders && hub_.dropped() == 1; }));
}

/// Halls of 24 m by 24 m side by side, seen by a lidar from nine places in each.
OccupancyGrid halls(int count) {
  constexpr double kSide = 24.0, kSigma = 0.015;  // [m]
  std::mt19937 random(1);
  std::normal_distribution<double> noise(0.0, kSigma);
  OccupancyGrid grid;
  std::vector<Keyframe::Point> points;
  for (int view = 0; view < 9 * count; ++view) {
    const double x = 4.0 + 8.0 * (view % 3), y = 4.0 + 8.0 * (view / 3 % 3);  // in its hall
    points.clear();
    for (int beam = 0; beam < 720; ++beam) {
      const double bearing = std::numbers::pi * (beam + 0.5) / 360.0, c = std::cos(bearing), s = std::sin(bearing);
      const double along_x = c > 0.0 ? (kSide - x) / c : -x / c, along_y = s > 0.0 ? (kSide - y) / s : -y / s;
      const double range = std::min(along_x, along_y) + noise(random);
      points.push_back({.x = static_cast<float>(range * c), .y = static_cast<float>(range * s)});
    }
    grid.add({kSide * (view / 9 % 6) + x, kSide * (view / 54) + y, 0.0}, {}, points);
  }
  return grid;
}

TEST_F(Server, SendsTwoThousandTilesInLessThanTwoMegabytes) {
  const OccupancyGrid grid = halls(36);
  int tiles = 0;
  grid.tiles().forEachTile([&](TileIndex tile, const auto&) {
    shared_.state.take(MapLayer::kBoth, toTileMessage(grid, tile, 1, 0), {});
    ++tiles;
  });
  ASSERT_GE(tiles, 2000);
  start();
  const std::string answer = get("/api/map");
  EXPECT_LT(answer.size(), 2'000'000U);
  EXPECT_EQ(test::tilesIn(answer.substr(answer.find("\r\n\r\n") + 4)).size(), static_cast<std::size_t>(tiles));
}

/// Bytes as a fuzzer begins with: requests, and requests with something wrong.
std::string someRequest(std::mt19937& random) {
  const auto pick = [&](std::initializer_list<const char*> from) { return *(from.begin() + random() % from.size()); };
  std::string text = pick({"GET ", "POST ", "HEAD ", "PUT ", "OPTIONS ", "", "GET", "PRI * HTTP/2.0\r\n\r\nSM\r\n\r\n",
                           "\x16\x03\x01\x02"});
  text += pick({"/", "/api/map", "/api/map?since=", "/api/status", "/api/command", "/logs/", "/logs/../", "/map.png",
                "*", "//", "/%", "/%2e%2e/", "?", "http://localhost/"});
  if (random() % 3 == 0) text += std::to_string(random());
  text += pick({" HTTP/1.1\r\n", " HTTP/1.0\r\n", " HTTP/9\r\n", "\r\n", "\n", ""});
  const std::size_t headers = random() % 6;
  for (std::size_t i = 0; i < headers; ++i) {
    text += pick({"Host: localhost", "Host: evil", "Content-Length: 5", "Content-Length: -1",
                  "Content-Length: 99999999999", "Transfer-Encoding: chunked", "Range: bytes=0-,1-,5-2",
                  "Range: bytes=-99999999999999999999", "Expect: 100-continue", "Accept-Encoding: gzip, br",
                  "Content-Type: multipart/form-data; boundary=", "Content-Type: application/json",
                  "Authorization: Bearer x", "Connection: keep-alive", "Connection: Upgrade", ": ", "x",
                  "Content-Encoding: gzip"});
    text += pick({"\r\n", "\r\n", "\r\n", "\n", "\r"});
  }
  text += pick({"\r\n", "\r\n", "\r\n{}", "\r\n5\r\nhello\r\n0\r\n\r\n", "\r\nffffffffffffffff\r\n", ""});
  const std::size_t changes = random() % 4;
  for (std::size_t i = 0; i < changes && !text.empty(); ++i) text[random() % text.size()] = static_cast<char>(random());
  return text;
}

TEST_F(Server, AnswersOrEndsEveryByteSequence) {
  settings_.web.commands = true;
  limits_.request = 100ms;
  start();
  std::mt19937 random(7);
  constexpr int kRequests = 5000;  // a hundred thousand: tools/fuzz web_request
  const double before = residentMegabytes();
  for (int i = 0; i < kRequests; ++i) {
    const std::string request = someRequest(random);
    const Client client(server_->port());
    ASSERT_TRUE(client.isConnected()) << i;
    client.say(request);
    client.endRequest();
    const std::string answer = client.hear("event: map");
    ASSERT_EQ(answer.find("[no end]"), std::string::npos) << i << ": " << request;
    ASSERT_THAT(answer, AnyOf("", StartsWith("HTTP/1.1 "))) << i << ": " << request;
    ASSERT_THAT(answer, testing::Not(StartsWith("HTTP/1.1 5"))) << i << ": " << request;
  }
  EXPECT_TRUE(commands_.empty());
  EXPECT_LT(residentMegabytes(), before + 50.0);
  EXPECT_THAT(get("/"), StartsWith("HTTP/1.1 200"));
}

}  // namespace
}  // namespace slam::web_server_test
