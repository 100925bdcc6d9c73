// SPDX-License-Identifier: BSD-3-Clause
#include "tools/sim/tcp_server.hpp"

#include <arpa/inet.h>
#include <cerrno>
#include <netinet/in.h>
#include <poll.h>
#include <sys/socket.h>
#include <system_error>
#include <unistd.h>

namespace slam::sim {

TcpServer::TcpServer(std::uint16_t port) : listener_(socket(AF_INET, SOCK_STREAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0)) {
  const int on = 1;
  setsockopt(listener_, SOL_SOCKET, SO_REUSEADDR, &on, sizeof on);
  sockaddr_in here{};
  here.sin_family = AF_INET;
  here.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  here.sin_port = htons(port);
  socklen_t size = sizeof here;
  auto* address = reinterpret_cast<sockaddr*>(&here);
  if (bind(listener_, address, size) != 0 || listen(listener_, 4) != 0 || getsockname(listener_, address, &size) != 0) {
    const int error = errno;
    close(listener_);
    throw std::system_error(error, std::generic_category(), "TCP port " + std::to_string(port));
  }
  port_ = ntohs(here.sin_port);
}

TcpServer::~TcpServer() { close(listener_); }

void TcpServer::letIn() {
  const int program = accept4(listener_, nullptr, nullptr, SOCK_NONBLOCK | SOCK_CLOEXEC);
  if (program < 0) return;
  stream_ ? void(close(program)) : void(stream_ = makeDescriptorStream(program));
}

std::size_t TcpServer::read(std::span<std::uint8_t> out, Duration timeout) {
  pollfd next{listener_, POLLIN, 0};
  const auto wait = stream_ ? 0 : static_cast<int>(timeout / std::chrono::milliseconds(1));
  const bool comes = ::poll(&next, 1, wait) > 0;
  if (comes) letIn();
  if (comes || !stream_) return 0;
  const ReadResult result = stream_->read(out, timeout);
  if (result.status == ReadResult::kClosed) stream_.reset();
  return result.size;
}

void TcpServer::send(std::span<const std::uint8_t> bytes) {
  if (stream_ && !stream_->write(bytes)) stream_.reset();
}

}  // namespace slam::sim
