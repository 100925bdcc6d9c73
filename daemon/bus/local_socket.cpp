// SPDX-License-Identifier: BSD-3-Clause
#include "bus/local_socket.hpp"

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <grp.h>
#include <sys/epoll.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <unistd.h>

#include "bus/local_client.hpp"

namespace slam {
namespace {

using Bytes = std::span<const std::uint8_t>;
constexpr Duration kLook = std::chrono::seconds(1);
constexpr int kMostAtOnce = 64, kBacklog = 8;
constexpr mode_t kOwnerAndGroup = 0660;
constexpr LocalSocket::Client kListener = 0;  // among the numbers of clients

std::optional<gid_t> groupNamed(const char* name) {
  const group* found = getgrnam(name);
  return found != nullptr ? std::optional(found->gr_gid) : std::nullopt;
}

}  // namespace

LocalSocket::LocalSocket(std::string path)
    : path_(std::move(path)), group_(path_.empty() ? std::nullopt : groupNamed(LocalClient::kGroup)) {}

LocalSocket::~LocalSocket() {
  stopListening();
  for (const Connection& client : clients_) ::close(client.socket);
  if (poll_ >= 0) ::close(poll_);
}

void LocalSocket::subscribe(const std::string& channel, Handler handler) {
  dispatcher_.subscribe(channel, [this, handler = std::move(handler)](Bytes message) { handler(sender_, message); });
}

void LocalSocket::tend(Timestamp now) {
  if (path_.empty() || now < next_look_) return;
  next_look_ = now + kLook;
  if (listener_ >= 0 && !hasFile()) stopListening();
  if (listener_ >= 0) return listen();
  problem_ = open();
}

Problem LocalSocket::open() {
  if (poll_ < 0) poll_ = epoll_create1(EPOLL_CLOEXEC);
  if (poll_ >= 0) listener_ = socket(AF_UNIX, SOCK_SEQPACKET | SOCK_CLOEXEC | SOCK_NONBLOCK, 0);
  if (listener_ < 0) return {problem::kSocketNoDescriptor, {}, {path_, std::strerror(errno)}};
  const Problem problem = bindFile();
  problem ? void(::close(std::exchange(listener_, -1))) : listen();
  return problem;
}

Problem LocalSocket::bindFile() {
  sockaddr_un address{};
  if (!toAddress(path_, address)) return {problem::kSocketTooLong, {}, {path_}};
  struct stat file {};
  const bool is_socket = lstat(path_.c_str(), &file) != 0 || S_ISSOCK(file.st_mode);
  switch (const int error = is_socket ? LocalClient::probe(path_) : ENOTSOCK) {
    case ENOENT:
      break;
    case ECONNREFUSED:  // of a slamd that was killed
      unlink(path_.c_str());
      break;
    case ENOTSOCK:
      return {problem::kSocketIsFile, {}, {path_}};
    case 0:
    case EAGAIN:
    case EPROTOTYPE:
      return {problem::kSocketTaken, {}, {path_}};
    default:
      return {problem::kSocketFails, {}, {path_, std::strerror(error)}};
  }
  // Open to nobody before it is open to those who may.
  fchmod(listener_, 0);
  if (bind(listener_, reinterpret_cast<const sockaddr*>(&address), sizeof address) != 0) {
    const std::string folder = path_.substr(0, path_.rfind('/') + 1);
    return {problem::kSocketNoFolder, {}, {path_, std::strerror(errno), folder.empty() ? "." : folder}};
  }
  lstat(path_.c_str(), &file);
  file_ = {file.st_dev, file.st_ino};
  // Only root and members may give it to the group; of all others it stays their own group's.
  if (group_ && *group_ != getegid() && chown(path_.c_str(), static_cast<uid_t>(-1), *group_) != 0) errno = 0;
  if (chmod(path_.c_str(), kOwnerAndGroup) != 0 || ::listen(listener_, kBacklog) != 0) {
    unlink(path_.c_str());
    return {problem::kSocketFails, {}, {path_, std::strerror(errno)}};
  }
  return {};
}

/// Also to one that is not listened to any more, because accept() had no descriptor left.
void LocalSocket::listen() {
  epoll_event event{.events = EPOLLIN, .data = {.u64 = kListener}};
  epoll_ctl(poll_, EPOLL_CTL_ADD, listener_, &event);
}

bool LocalSocket::hasFile() const {
  struct stat file {};
  return lstat(path_.c_str(), &file) == 0 && std::pair(file.st_dev, file.st_ino) == file_;
}

void LocalSocket::stopListening() {
  if (listener_ < 0) return;
  ::close(std::exchange(listener_, -1));
  if (hasFile()) unlink(path_.c_str());
}

void LocalSocket::receive() {
  std::array<epoll_event, kMostClients + 1> ready{};
  for (int taken = 0; taken < kMostAtOnce && poll_ >= 0;) {  // in turns: who sends much does not keep others waiting
    const int count = epoll_wait(poll_, ready.data(), static_cast<int>(ready.size()), 0);
    if (count <= 0) return;
    taken += count;
    for (const epoll_event& event : std::span(ready).first(static_cast<std::size_t>(count))) {
      event.data.u64 == kListener ? accept() : take(event.data.u64);
    }
  }
}

void LocalSocket::accept() {
  const int socket = accept4(listener_, nullptr, nullptr, SOCK_CLOEXEC | SOCK_NONBLOCK);
  if (socket < 0) {
    if (errno != EAGAIN && errno != ECONNABORTED) epoll_ctl(poll_, EPOLL_CTL_DEL, listener_, nullptr);
    return;
  }
  epoll_event event{.events = EPOLLIN, .data = {.u64 = next_client_}};
  if (epoll_ctl(poll_, EPOLL_CTL_ADD, socket, &event) != 0) {
    ::close(socket);
    ++counts_.refused;
    return;
  }
  if (clients_.size() == kMostClients) {
    // Who has never asked for anything waits for no answer.
    const auto silent =
        std::find_if(clients_.begin(), clients_.end(), [](const Connection& c) { return !c.has_asked; });
    drop((silent == clients_.end() ? clients_.begin() : silent)->id);
    ++counts_.refused;
  }
  clients_.push_back({next_client_++, socket});
}

void LocalSocket::take(Client client) {
  const auto at = std::find_if(clients_.begin(), clients_.end(), [&](const Connection& c) { return c.id == client; });
  if (at == clients_.end()) return;
  const ssize_t size = recv(at->socket, received_.data(), received_.size(), MSG_TRUNC);
  if (size < 0 && (errno == EAGAIN || errno == EINTR)) return;
  if (size <= 0) return drop(client);  // it has gone; an empty packet looks the same
  if (static_cast<std::size_t>(size) > received_.size()) {
    ++counts_.bad;
    return;
  }
  at->has_asked = true;
  std::rotate(at, at + 1, clients_.end());
  sender_ = client;
  dispatcher_.take(std::span(received_).first(static_cast<std::size_t>(size)));
}

bool LocalSocket::send(Client client, const std::string& channel, Bytes data) {
  const auto at = std::find_if(clients_.begin(), clients_.end(), [&](const Connection& c) { return c.id == client; });
  if (at == clients_.end()) return false;
  writePacket(channel, data, packet_);
  if (sendPacket(at->socket)) return true;
  drop(client);
  return false;
}

void LocalSocket::sendAll(const std::string& channel, Bytes data) {
  if (clients_.empty()) return;
  writePacket(channel, data, packet_);
  const std::vector<Connection> all = clients_;
  for (const Connection& client : all) {
    if (!sendPacket(client.socket)) drop(client.id);
  }
}

bool LocalSocket::sendPacket(int socket) {
  if (::send(socket, packet_.data(), packet_.size(), MSG_DONTWAIT | MSG_NOSIGNAL) >= 0) return true;
  if (errno == EAGAIN) ++counts_.dropped;
  return false;
}

void LocalSocket::drop(Client client) {
  const auto at = std::find_if(clients_.begin(), clients_.end(), [&](const Connection& c) { return c.id == client; });
  ::close(at->socket);
  clients_.erase(at);
}

LocalSocket::Counts LocalSocket::counts() const {
  Counts counts = counts_;
  counts.bad += dispatcher_.counts().fragments + dispatcher_.counts().others;
  return counts;
}

}  // namespace slam
