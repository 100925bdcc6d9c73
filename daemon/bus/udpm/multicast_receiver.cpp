// SPDX-License-Identifier: BSD-3-Clause
#include "bus/udpm/multicast_receiver.hpp"

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <sys/socket.h>
#include <unistd.h>
#include <utility>

namespace slam {
namespace {

constexpr int kReceiveBuffer = 2 << 20;  // [bytes] asked for; net.core.rmem_max limits it

bool setOption(int fd, int level, int option, int value) {
  return setsockopt(fd, level, option, &value, sizeof value) == 0;
}

/// On the interface that the route goes over, which the kernel chooses. @return 0 or the error: EADDRINUSE on one where
/// this socket is a member already, ENODEV without a route
int addMembership(int fd, const UdpmUrl& url) {
  const ip_mreq request{.imr_multiaddr = url.group.sin_addr, .imr_interface = {.s_addr = htonl(INADDR_ANY)}};
  return setsockopt(fd, IPPROTO_IP, IP_ADD_MEMBERSHIP, &request, sizeof request) == 0 ? 0 : errno;
}

}  // namespace

MulticastReceiver::Joined MulticastReceiver::open() {
  const int fd = socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0);
  if (fd < 0) return Joined::kNoSocket;
  setOption(fd, SOL_SOCKET, SO_RCVBUF, std::max(kReceiveBuffer, url_.receive_buffer));
  setOption(fd, SOL_SOCKET, SO_RXQ_OVFL, 1);
  // Bound to the group as liblcm's are: what is sent to this machine's own address is not LCM's.
  const bool bound = setOption(fd, SOL_SOCKET, SO_REUSEADDR, 1) &&
                     bind(fd, reinterpret_cast<const sockaddr*>(&url_.group), sizeof url_.group) == 0;
  const int error = bound ? addMembership(fd, url_) : 0;
  if (!bound || error != 0) {
    ::close(fd);
    return error == ENODEV ? Joined::kNoRoute : Joined::kNoSocket;
  }
  const int before = std::exchange(socket_, fd);
  if (before >= 0) ::close(before);
  overflow_ = 0;
  return Joined::kAnew;
}

MulticastReceiver::Joined MulticastReceiver::join() {
  if (socket_ < 0) return open();
  switch (addMembership(socket_, url_)) {
    case EADDRINUSE:
      return Joined::kAsBefore;
    case ENODEV:
      return Joined::kNoRoute;
    default:  // a member on two interfaces now: a new socket is one on the new interface alone
      return open();
  }
}

void MulticastReceiver::close() {
  if (socket_ >= 0) ::close(std::exchange(socket_, -1));
}

std::optional<std::span<const std::uint8_t>> MulticastReceiver::next() {
  if (socket_ < 0) return std::nullopt;
  iovec room{buffer_.data(), buffer_.size()};
  alignas(cmsghdr) char control[CMSG_SPACE(sizeof overflow_)];
  sockaddr_in from{};
  msghdr message{};
  message.msg_name = &from;
  message.msg_namelen = sizeof from;
  message.msg_iov = &room;
  message.msg_iovlen = 1;
  message.msg_control = control;
  message.msg_controllen = sizeof control;
  const ssize_t size = recvmsg(socket_, &message, 0);
  if (size < 0) return std::nullopt;
  sender_ = std::uint64_t{ntohl(from.sin_addr.s_addr)} << 16 | ntohs(from.sin_port);
  const cmsghdr* head = CMSG_FIRSTHDR(&message);
  if (head != nullptr && head->cmsg_level == SOL_SOCKET && head->cmsg_type == SO_RXQ_OVFL) {
    const std::uint32_t before = overflow_;
    std::memcpy(&overflow_, CMSG_DATA(head), sizeof overflow_);
    dropped_ += overflow_ - before;
  }
  return std::span(buffer_).first(static_cast<std::size_t>(size));
}

}  // namespace slam
