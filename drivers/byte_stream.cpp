// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/byte_stream.hpp"

#include <array>
#include <cerrno>
#include <chrono>
#include <fcntl.h>
#include <poll.h>
#include <sys/epoll.h>
#include <sys/socket.h>
#include <termios.h>
#include <unistd.h>
#include <utility>

#include "drivers/serial_port.hpp"
#include "drivers/tcp_port.hpp"

namespace slam {
namespace {

/// Waits by edge-triggered epoll. poll(), and a read without data, would wait for the kernel thread that hands a
/// terminal its bytes (n_tty_poll and n_tty_read call tty_buffer_flush_work), and that has normal priority: on an
/// overloaded computer a real-time thread waited for seconds. An edge is looked at only when bytes have come.
class EdgeStream : public ByteStream {
 public:
  EdgeStream(int descriptor, int edges) : descriptor_(descriptor), edges_(edges) {}
  ~EdgeStream() override { close(edges_); }

  ReadResult read(std::span<std::uint8_t> out, Duration timeout) override {
    if (more_ || hung_up_) {
      const ReadResult left = takeInto(out);
      if (left.status != ReadResult::kTimeout) return left;
    }
    epoll_event event{};
    const auto limit = std::chrono::ceil<std::chrono::milliseconds>(timeout);
    const int ready = epoll_wait(edges_, &event, 1, static_cast<int>(limit.count()));
    if (ready < 0) return {errno == EINTR ? ReadResult::kTimeout : ReadResult::kClosed, 0};
    if (ready == 0) return {};
    hung_up_ = (event.events & (EPOLLHUP | EPOLLERR | EPOLLRDHUP)) != 0;
    return takeInto(out);
  }
  bool write(std::span<const std::uint8_t> bytes) override {
    while (!bytes.empty()) {
      const ssize_t n = writeSome(bytes);
      if (n < 0 && errno == EINTR) continue;
      if (n <= 0) return false;
      bytes = bytes.subspan(static_cast<std::size_t>(n));
    }
    return true;
  }

 protected:
  int descriptor() const { return descriptor_; }
  virtual ssize_t writeSome(std::span<const std::uint8_t> bytes) {
    return ::write(descriptor_, bytes.data(), bytes.size());
  }
  /// @return bytes taken without waiting; -1: hung up
  int take(std::span<std::uint8_t> out) {
    const ssize_t n = ::read(descriptor_, out.data(), out.size());
    if (n > 0) return static_cast<int>(n);
    return n < 0 && (errno == EAGAIN || errno == EINTR) ? 0 : -1;
  }

 private:
  ReadResult takeInto(std::span<std::uint8_t> out) {
    const int n = take(out);
    more_ = n == static_cast<int>(out.size());  // no edge tells of what is left
    if (n > 0) return {ReadResult::kData, static_cast<std::size_t>(n)};
    return {n < 0 || hung_up_ ? ReadResult::kClosed : ReadResult::kTimeout, 0};
  }

  int descriptor_, edges_;
  bool more_ = false, hung_up_ = false;
};

class DescriptorStream : public EdgeStream {
 public:
  using EdgeStream::EdgeStream;
  ~DescriptorStream() override { close(descriptor()); }

  void discardInput() override {
    std::array<std::uint8_t, 256> away;
    if (tcflush(descriptor(), TCIFLUSH) == 0) return;
    while (take(away) > 0) {
    }
  }
  bool setDtr(bool) override { return false; }

 protected:
  /// Without a signal where the other end of a connection has gone.
  ssize_t writeSome(std::span<const std::uint8_t> bytes) override {
    const ssize_t n = ::send(descriptor(), bytes.data(), bytes.size(), MSG_NOSIGNAL);
    return n < 0 && errno == ENOTSOCK ? EdgeStream::writeSome(bytes) : n;
  }
};

class PortStream : public EdgeStream {
 public:
  PortStream(std::unique_ptr<SerialPort> port, int edges)
      : EdgeStream(port->descriptor(), edges), port_(std::move(port)) {}

  void discardInput() override { port_->discardInput(); }
  bool setDtr(bool on) override { return port_->setDtr(on); }

 private:
  std::unique_ptr<SerialPort> port_;
};

/// An epoll of a descriptor that never waits; -1: none can be had.
int makeEdges(int descriptor) {
  fcntl(descriptor, F_SETFL, fcntl(descriptor, F_GETFL) | O_NONBLOCK);
  const int edges = epoll_create1(EPOLL_CLOEXEC);
  epoll_event event{};
  event.events = EPOLLIN | EPOLLRDHUP | EPOLLET;  // a hang-up is told of, too
  if (edges < 0 || epoll_ctl(edges, EPOLL_CTL_ADD, descriptor, &event) == 0) return edges;
  close(edges);
  return -1;
}

}  // namespace

void ByteStream::rest(Duration time) {
  const timespec limit{static_cast<time_t>(time.count() / 1000000000), static_cast<long>(time.count() % 1000000000)};
  ppoll(nullptr, 0, &limit, nullptr);
}

std::unique_ptr<ByteStream> makeDescriptorStream(int descriptor) {
  const int edges = makeEdges(descriptor);
  if (edges >= 0) return std::make_unique<DescriptorStream>(descriptor, edges);
  close(descriptor);
  return nullptr;
}

OpenedPort openPort(const std::string& path, int baud) {
  if (isTcp(path)) return openTcp(path);
  auto port = std::make_unique<SerialPort>();
  if (const Problem problem = port->open(path, baud)) return {nullptr, problem};
  const int edges = makeEdges(port->descriptor());
  if (edges < 0) return {nullptr, problem::kNoDescriptors};
  return {std::make_unique<PortStream>(std::move(port), edges), {}};
}

}  // namespace slam
