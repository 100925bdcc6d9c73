// SPDX-License-Identifier: BSD-3-Clause
#include "tools/web/foxglove/foxglove_hub.hpp"

#include <algorithm>
#include <array>
#include <cerrno>
#include <nlohmann/json.hpp>
#include <poll.h>
#include <sys/eventfd.h>
#include <sys/socket.h>
#include <unistd.h>

#include "runtime/clock.hpp"
#include "tools/foxglove/foxglove_json.hpp"
#include "tools/slamctl/health_json.hpp"
#include "tools/web/foxglove/foxglove_session.hpp"
#include "tools/web/foxglove/web_socket.hpp"
#include "tools/web/oldest_of_most.hpp"

namespace slam {
namespace {

using namespace std::chrono_literals;
constexpr std::uint16_t kPolicyViolation = 1008;    // RFC 6455, section 7.4.1
constexpr Duration kMapSoonest = 500ms;             // however often one subscribes
constexpr int kDrawingShare = 20;                   // of the time one part is spent on drawing maps
constexpr std::chrono::milliseconds kLook = 100ms;  // for maps that are due, and for those who take nothing

MapPicture::Picture pictureOf(const MapImage& image, std::int64_t utime) {
  MapPicture::Picture picture{utime,        {image.origin_x, image.origin_y, 0.0},  image.resolution, image.width,
                              image.height, std::string(image.cells.size(), '\xFF')};
  for (int row = 0; row < image.height; ++row) {
    for (int column = 0; column < image.width; ++column) {
      const std::uint8_t cell = image.at(column, row);
      if (cell == MapImage::kUnknown) continue;
      picture.cells[static_cast<std::size_t>(row) * static_cast<std::size_t>(image.width) +
                    static_cast<std::size_t>(column)] = cell == MapImage::kOccupied ? 100 : 0;
    }
  }
  return picture;
}

std::shared_ptr<const std::string> bodyOf(const nlohmann::json& message) {
  return std::make_shared<const std::string>(textOf(message));
}

/// A picture of half the resolution: of four cells the one most likely occupied, if any is known.
MapPicture::Picture halved(const MapPicture::Picture& map) {
  constexpr char kUnknown = '\xFF';
  MapPicture::Picture half{map.utime, map.corner, 2.0 * map.resolution, (map.columns + 1) / 2, (map.rows + 1) / 2, {}};
  half.cells.assign(static_cast<std::size_t>(half.columns * half.rows), kUnknown);
  for (std::int64_t row = 0; row < map.rows; ++row) {
    for (std::int64_t column = 0; column < map.columns; ++column) {
      const char cell = map.cells[static_cast<std::size_t>(row * map.columns + column)];
      char& into = half.cells[static_cast<std::size_t>(row / 2 * half.columns + column / 2)];
      if (cell != kUnknown) into = into == kUnknown ? cell : std::max(into, cell);  // in percent: no sign
    }
  }
  return half;
}

}  // namespace

struct FoxgloveHub::Client {
  Client(FoxgloveHub& hub, int of, std::string from, Timestamp now)
      : socket(of),
        address(std::move(from)),
        progress(now),
        web_socket({.most_unsent = hub.limits_.most_unsent},
                   [&hub, this](std::string_view text) { hub.answer(*this, text); }) {}
  ~Client() { ::close(socket); }
  Client(const Client&) = delete;
  Client& operator=(const Client&) = delete;
  void sendText(std::string text) { web_socket.send({std::move(text), nullptr, false}); }

  const int socket;
  const std::string address;
  Timestamp progress;  // when it took something last
  WebSocket web_socket;
  FoxgloveSession session;
  bool has_output = false;
};

FoxgloveHub::FoxgloveHub(SharedState& shared, const Config& config, std::string session, const FoxgloveLimits& limits)
    : shared_(shared),
      limits_(limits),
      session_(std::move(session)),
      wake_(eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK)),
      feed_([this](FoxgloveTopic topic, std::int64_t, const nlohmann::json& message) { send(topic, bodyOf(message)); },
            [this](FoxgloveTopic topic) { return (wanted_ >> static_cast<unsigned>(topic) & 1U) != 0; }),
      thread_([this] { run(); }) {
  const std::lock_guard lock(mutex_);
  feed_.mount(config);
}

FoxgloveHub::~FoxgloveHub() {
  ending_ = true;
  wake();
  thread_.join();
  ::close(wake_);
}

void FoxgloveHub::wake() const { eventfd_write(wake_, 1); }

void FoxgloveHub::add(int socket, std::string address, std::string_view received) {
  const std::lock_guard lock(mutex_);
  auto client = std::make_unique<Client>(*this, socket, std::move(address), monotonicNow());
  client->sendText(foxgloveServerInfo("slamd", session_));
  client->sendText(foxgloveAdvertisement());
  client->has_output = true;
  client->web_socket.receive(received);
  clients_.push_back(std::move(client));
  if (clients_.size() > limits_.most) makePlace();
  wake();
}

void FoxgloveHub::makePlace() {
  const auto index = oldestOfMost(clients_, [](const auto& client) { return std::string_view(client->address); });
  clients_.erase(clients_.begin() + static_cast<std::ptrdiff_t>(index));
  ++shared_.foxglove.ended_clients;
}

void FoxgloveHub::answer(Client& client, std::string_view text) {
  FoxgloveSession::Reply reply = client.session.take(text);
  if (reply.begun[static_cast<std::size_t>(FoxgloveTopic::kMap)]) map_.asked = true;
  if (!reply.text.empty()) client.sendText(std::move(reply.text));
  if (reply.ends) {
    client.web_socket.close(kPolicyViolation, "too many messages that are wrong");
    ++shared_.foxglove.ended_clients;
  }
}

void FoxgloveHub::send(FoxgloveTopic topic, const std::shared_ptr<const std::string>& body) {
  const std::int64_t received = toMicroseconds(monotonicNow() + wallClockOffset());
  for (const auto& client : clients_) {
    const auto subscription = client->session.subscriptionTo(topic);
    if (!subscription) continue;
    shared_.foxglove.dropped_messages +=
        client->web_socket.send({foxgloveMessageHead(*subscription, received), body, true});
    client->has_output = true;
  }
  wake();
}

void FoxgloveHub::run() {
  while (!ending_) {
    const std::vector<int> readable = wait();
    const Timestamp now = monotonicNow();
    tend(readable, now);
    const bool is_wanted = (wanted_ >> static_cast<unsigned>(FoxgloveTopic::kMap) & 1U) != 0;
    if (is_wanted && now >= map_.due) drawMap();
  }
}

/// @return the sockets that can be read
std::vector<int> FoxgloveHub::wait() {
  std::vector<pollfd> waiting{{wake_, POLLIN, 0}};
  {
    const std::lock_guard lock(mutex_);
    for (const auto& client : clients_)
      waiting.push_back({client->socket, static_cast<short>(client->has_output ? POLLIN | POLLOUT : POLLIN), 0});
  }
  ::poll(waiting.data(), waiting.size(), static_cast<int>(kLook.count()));
  eventfd_t count = 0;
  eventfd_read(wake_, &count);
  std::vector<int> readable;
  for (std::size_t i = 1; i < waiting.size(); ++i) {
    if ((waiting[i].revents & ~POLLOUT) != 0) readable.push_back(waiting[i].fd);
  }
  return readable;
}

void FoxgloveHub::tend(const std::vector<int>& readable, Timestamp now) {
  const std::lock_guard lock(mutex_);
  std::erase_if(clients_, [&](const auto& client) {
    return !serve(*client, std::find(readable.begin(), readable.end(), client->socket) != readable.end(), now);
  });
  std::uint32_t wanted = 0;
  for (const auto& client : clients_) {
    for (std::size_t i = 0; i < kFoxgloveTopics; ++i)
      if (client->session.isWanted(static_cast<FoxgloveTopic>(i))) wanted |= 1U << i;
  }
  wanted_ = wanted;
  shared_.foxglove.clients = clients_.size();
}

/// @return false: this client is gone, or has to go
bool FoxgloveHub::serve(Client& client, bool readable, Timestamp now) {
  if (readable) {
    std::array<char, 16 * 1024> bytes;
    const ssize_t got = ::recv(client.socket, bytes.data(), bytes.size(), MSG_DONTWAIT);
    if (got == 0 || (got < 0 && errno != EAGAIN && errno != EINTR)) return false;
    if (got > 0) client.web_socket.receive({bytes.data(), static_cast<std::size_t>(got)});
  }
  std::string_view output = client.web_socket.output();
  if (output.empty()) client.progress = now;
  while (!output.empty()) {
    const ssize_t sent = ::send(client.socket, output.data(), output.size(), MSG_DONTWAIT | MSG_NOSIGNAL);
    if (sent < 0 && errno != EAGAIN && errno != EINTR) return false;
    if (sent <= 0) break;
    client.web_socket.written(static_cast<std::size_t>(sent));
    client.progress = now;
    output = client.web_socket.output();
  }
  client.has_output = !output.empty();
  if (client.web_socket.isOver()) return false;
  const bool is_slow = client.has_output && now - client.progress > limits_.patience;
  shared_.foxglove.ended_clients += is_slow;
  return !is_slow;
}

/// Where it has changed, or somebody is new.
void FoxgloveHub::drawMap() {
  const Timestamp begin = monotonicNow();
  const bool is_asked = map_.asked.exchange(false);
  std::optional<MapImage> image;
  std::int64_t utime = 0;
  {
    const std::lock_guard lock(shared_.mutex);
    const TileStore& tiles = shared_.state.tiles();
    if ((!is_asked && map_.version == tiles.version()) || tiles.size() == 0) {
      map_.asked = map_.asked || (is_asked && tiles.size() == 0);
      map_.due = begin + kMapSoonest;
      return;
    }
    map_.version = tiles.version();
    image = tiles.image();
    utime = shared_.state.meta() ? shared_.state.meta()->utime : 0;
  }
  if (image) {
    MapPicture::Picture picture = pictureOf(*image, utime);
    while (picture.columns * picture.rows > limits_.most_cells) picture = halved(picture);
    const auto body = bodyOf(foxglove::grid(picture));  // which others need not wait for
    const std::lock_guard lock(mutex_);
    send(FoxgloveTopic::kMap, body);
  }
  const Timestamp end = monotonicNow();
  map_.due = std::max(end + limits_.map_period, begin + kDrawingShare * (end - begin));
}

}  // namespace slam
