// SPDX-License-Identifier: BSD-3-Clause
#include "bus/local_client.hpp"

#include <cerrno>
#include <cstring>
#include <poll.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <unistd.h>
#include <utility>

#include "bus/udpm/lc02.hpp"

namespace slam {

bool toAddress(const std::string& path, sockaddr_un& address) {
  if (path.empty() || path.size() >= sizeof address.sun_path) return false;
  address = {};
  address.sun_family = AF_UNIX;
  std::memcpy(address.sun_path, path.data(), path.size());
  return true;
}

int LocalClient::open(const std::string& path) {
  close();
  sockaddr_un address{};
  if (!toAddress(path, address)) return ENAMETOOLONG;
  struct stat file {};
  if (stat(path.c_str(), &file) != 0) return errno;
  if (!S_ISSOCK(file.st_mode)) return ENOTSOCK;  // connect() would say that nobody listens
  socket_ = socket(AF_UNIX, SOCK_SEQPACKET | SOCK_CLOEXEC | SOCK_NONBLOCK, 0);
  if (socket_ < 0) return errno;
  if (connect(socket_, reinterpret_cast<const sockaddr*>(&address), sizeof address) == 0) return 0;
  const int error = errno;
  close();
  return error;
}

void LocalClient::close() {
  if (socket_ >= 0) ::close(std::exchange(socket_, -1));
}

std::optional<pid_t> LocalClient::peer() const {
  ucred who{};
  socklen_t size = sizeof who;
  if (!isOpen() || getsockopt(socket_, SOL_SOCKET, SO_PEERCRED, &who, &size) != 0 || who.pid <= 0) return std::nullopt;
  return who.pid;
}

bool LocalClient::send(const std::string& channel, std::span<const std::uint8_t> data) {
  writePacket(channel, data, packet_);
  return isOpen() && ::send(socket_, packet_.data(), packet_.size(), MSG_DONTWAIT | MSG_NOSIGNAL) >= 0;
}

std::optional<std::span<const std::uint8_t>> LocalClient::next(std::chrono::milliseconds wait) {
  pollfd waiting{socket_, POLLIN, 0};
  if (!isOpen() || ::poll(&waiting, 1, static_cast<int>(wait.count())) <= 0) return std::nullopt;
  const ssize_t size = recv(socket_, received_.data(), received_.size(), MSG_TRUNC);
  if (size < 0 && (errno == EAGAIN || errno == EINTR)) return std::nullopt;
  if (size <= 0) {
    close();
    return std::nullopt;
  }
  const auto whole = static_cast<std::size_t>(size);
  return std::span(received_).first(whole <= received_.size() ? whole : 0);
}

}  // namespace slam
