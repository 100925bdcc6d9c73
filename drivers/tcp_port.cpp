// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/tcp_port.hpp"

#include <arpa/inet.h>
#include <cerrno>
#include <charconv>
#include <cstring>
#include <netdb.h>
#include <netinet/tcp.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

namespace slam {
namespace {

constexpr std::string_view kScheme = "tcp://";
constexpr int kPatience = 1000;  // [ms] for the device to accept: on a network of one room it takes one

Problem connectProblem(int error, const std::string& path) {
  switch (error) {
    case ECONNREFUSED:
    case ECONNRESET:
      return {problem::kTcpRefused, {}, {path}};
    case EHOSTUNREACH:
    case ENETUNREACH:
    case EADDRNOTAVAIL:
      return {problem::kTcpNoWay, {}, {path}};
    case ETIMEDOUT:
      return {problem::kTcpNoReply, {}, {path}};
    case EMFILE:
    case ENFILE:
      return problem::kNoDescriptors;
    default:
      return {problem::kPortNotOpened, {}, {std::strerror(error)}};
  }
}

/// @return errno; 0: connected
int connectWithin(int socket, const addrinfo& to) {
  if (connect(socket, to.ai_addr, to.ai_addrlen) == 0) return 0;
  if (errno != EINPROGRESS) return errno;
  pollfd wanted{socket, POLLOUT, 0};
  const int ready = ::poll(&wanted, 1, kPatience);
  if (ready <= 0) return ready == 0 ? ETIMEDOUT : errno;
  int error = 0;
  socklen_t size = sizeof error;
  getsockopt(socket, SOL_SOCKET, SO_ERROR, &error, &size);
  return error;
}

}  // namespace

bool isTcp(std::string_view path) { return path.starts_with(kScheme); }

std::optional<TcpAddress> parseTcp(std::string_view path) {
  if (!isTcp(path)) return std::nullopt;
  path.remove_prefix(kScheme.size());
  const std::size_t colon = path.rfind(':');
  if (colon == std::string_view::npos) return std::nullopt;
  const std::string_view number = path.substr(colon + 1);
  std::string_view host = path.substr(0, colon);
  TcpAddress address;
  const auto [end, error] = std::from_chars(number.data(), number.data() + number.size(), address.port);
  if (error != std::errc() || end != number.data() + number.size() || address.port == 0) return std::nullopt;
  const bool six = host.size() > 2 && host.front() == '[' && host.back() == ']';
  if (six) host = host.substr(1, host.size() - 2);
  address.host = host;
  in6_addr binary{};
  if (inet_pton(six ? AF_INET6 : AF_INET, address.host.substr(0, address.host.find('%')).c_str(), &binary) != 1)
    return std::nullopt;
  return address;
}

OpenedPort openTcp(const std::string& path) {
  const auto address = parseTcp(path);
  addrinfo hints{}, *found = nullptr;
  hints.ai_flags = AI_NUMERICHOST | AI_NUMERICSERV;
  hints.ai_socktype = SOCK_STREAM;
  if (!address || getaddrinfo(address->host.c_str(), std::to_string(address->port).c_str(), &hints, &found) != 0)
    return {nullptr, {problem::kTcpAddressBad, {}, {path}}};
  const int socket = ::socket(found->ai_family, SOCK_STREAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0);
  const int error = socket < 0 ? errno : connectWithin(socket, *found);
  freeaddrinfo(found);
  if (error != 0) {
    if (socket >= 0) close(socket);
    return {nullptr, connectProblem(error, path)};
  }
  const int on = 1;
  setsockopt(socket, IPPROTO_TCP, TCP_NODELAY, &on, sizeof on);  // a command is not to wait for others
  auto stream = makeDescriptorStream(socket);
  if (!stream) return {nullptr, problem::kNoDescriptors};
  return {std::move(stream), {}};
}

}  // namespace slam
