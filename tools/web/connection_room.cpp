// SPDX-License-Identifier: BSD-3-Clause
#include "tools/web/connection_room.hpp"

#include <algorithm>
#include <arpa/inet.h>
#include <array>
#include <cctype>
#include <charconv>
#include <iterator>
#include <netinet/in.h>
#include <string_view>
#include <sys/epoll.h>
#include <sys/socket.h>
#include <unistd.h>
#include <utility>

#include "tools/web/oldest_of_most.hpp"

namespace slam {
namespace {

constexpr std::string_view kSlow = "HTTP/1.1 408 Request Timeout\r\nContent-Length: 0\r\nConnection: close\r\n\r\n";

/// The value of a header, without blanks around; empty: it is not there. @param head in lower case
std::string_view headerIn(std::string_view head, std::string_view name) {
  const auto at = head.find(name);
  if (at == std::string_view::npos) return "";
  const auto begin = head.find_first_not_of(" \t", at + name.size());
  return begin == std::string_view::npos ? "" : head.substr(begin, head.find("\r\n", begin) - begin);
}

}  // namespace

bool isWholeRequest(std::string_view bytes) {
  constexpr std::string_view kEnd = "\r\n\r\n";
  const auto end = bytes.find(kEnd);
  if (end == std::string_view::npos) return false;
  std::string head(bytes.substr(0, end + 2));
  std::transform(head.begin(), head.end(), head.begin(), [](unsigned char c) { return std::tolower(c); });
  const std::string_view body = bytes.substr(end + kEnd.size());
  if (headerIn(head, "\r\ntransfer-encoding:") == "chunked") return body.ends_with("0\r\n\r\n");
  const std::string_view length = headerIn(head, "\r\ncontent-length:");
  std::size_t size = 0;
  const auto [rest, error] = std::from_chars(length.data(), length.data() + length.size(), size);
  return error != std::errc() || body.size() >= size;  // a length that is none is refused by who reads it
}

std::string addressOf(int socket) {
  sockaddr_storage address{};
  socklen_t size = sizeof address;
  char text[INET6_ADDRSTRLEN] = {};
  if (getpeername(socket, reinterpret_cast<sockaddr*>(&address), &size) != 0) return "";
  if (address.ss_family == AF_INET)
    inet_ntop(AF_INET, &reinterpret_cast<const sockaddr_in&>(address).sin_addr, text, sizeof text);
  if (address.ss_family == AF_INET6) {
    in6_addr network = reinterpret_cast<const sockaddr_in6&>(address).sin6_addr;
    constexpr std::size_t kNetwork = 8;  // [bytes]
    const bool is_v4 = IN6_IS_ADDR_V4MAPPED(&network);
    if (!is_v4) std::fill(std::begin(network.s6_addr) + kNetwork, std::end(network.s6_addr), 0);
    inet_ntop(AF_INET6, &network, text, sizeof text);
  }
  return text;
}

ConnectionRoom::ConnectionRoom(const Limits& limits) : limits_(limits), poll_(epoll_create1(EPOLL_CLOEXEC)) {}

ConnectionRoom::~ConnectionRoom() {
  for (const Connection& connection : waiting_) ::close(connection.socket);
  if (poll_ >= 0) ::close(poll_);
}

void ConnectionRoom::add(int socket, std::string address, Timestamp now, bool redirects) {
  const std::lock_guard lock(mutex_);
  waiting_.push_back({.socket = socket, .address = std::move(address), .since = now, .redirects = redirects});
  epoll_event event{.events = EPOLLIN | EPOLLRDHUP | EPOLLET, .data = {.fd = socket}};
  epoll_ctl(poll_, EPOLL_CTL_ADD, socket, &event);
  if (waiting_.size() <= limits_.most) return;
  drop(oldestOfMost(waiting_, [](const Connection& connection) { return std::string_view(connection.address); }));
}

void ConnectionRoom::wait(std::chrono::milliseconds limit) {
  std::array<epoll_event, 16> events{};
  const int count = epoll_wait(poll_, events.data(), static_cast<int>(events.size()), static_cast<int>(limit.count()));
  const std::lock_guard lock(mutex_);
  for (int i = 0; i < count; ++i) {
    const auto at = std::find_if(waiting_.begin(), waiting_.end(), [&](const Connection& connection) {
      return connection.socket == events[static_cast<std::size_t>(i)].data.fd;
    });
    if (at != waiting_.end() && (events[static_cast<std::size_t>(i)].events & ~EPOLLIN) != 0) at->ended = true;
  }
}

std::size_t ConnectionRoom::size() const {
  const std::lock_guard lock(mutex_);
  return waiting_.size();
}

std::uint64_t ConnectionRoom::dropped() const {
  const std::lock_guard lock(mutex_);
  return dropped_;
}

void ConnectionRoom::drop(std::size_t index) {
  const int socket = waiting_[index].socket;
  ::send(socket, kSlow.data(), kSlow.size(), MSG_DONTWAIT | MSG_NOSIGNAL);
  ::close(socket);
  waiting_.erase(waiting_.begin() + static_cast<std::ptrdiff_t>(index));
  ++dropped_;
}

std::vector<ConnectionRoom::Connection> ConnectionRoom::takeReady(Timestamp now) {
  const std::lock_guard lock(mutex_);
  std::vector<Connection> ready;
  for (std::size_t i = 0; i < waiting_.size();) {
    const Connection& connection = waiting_[i];
    const ssize_t size = ::recv(connection.socket, seen_.data(), seen_.size(), MSG_PEEK | MSG_DONTWAIT);
    const std::string_view seen(seen_.data(), static_cast<std::size_t>(std::max<ssize_t>(size, 0)));
    if (connection.ended || size == 0 || seen.size() >= seen_.size() || isWholeRequest(seen)) {
      epoll_ctl(poll_, EPOLL_CTL_DEL, connection.socket, nullptr);
      ready.push_back(std::move(waiting_[i]));
      waiting_.erase(waiting_.begin() + static_cast<std::ptrdiff_t>(i));
    } else if (now - connection.since > limits_.request) {
      drop(i);
    } else {
      ++i;
    }
  }
  return ready;
}

}  // namespace slam
