// SPDX-License-Identifier: BSD-3-Clause
#include "tools/web/access/tls_front.hpp"

#include <array>
#include <cerrno>
#include <fcntl.h>
#include <openssl/err.h>
#include <openssl/ssl.h>
#include <poll.h>
#include <string_view>
#include <sys/eventfd.h>
#include <sys/socket.h>
#include <unistd.h>
#include <utility>

#include "runtime/clock.hpp"
#include "tools/web/oldest_of_most.hpp"

namespace slam {
namespace {

constexpr std::uint8_t kHandshakeRecord = 0x16;  // RFC 8446, section 5.1: the first byte of who speaks TLS
constexpr int kLook = 100;                       // [ms] for those that have had too much time
constexpr std::size_t kPart = 16 * 1024;         // [bytes] of a TLS record

struct SslDeleter {
  void operator()(SSL* ssl) const { SSL_free(ssl); }
};

bool isPassing(int error) { return error == EAGAIN || error == EINTR; }

}  // namespace

struct TlsFront::Connection {
  Connection(int of, std::string from, Timestamp now) : outer(of), address(std::move(from)), progress(now) {}
  ~Connection() {
    if (outer >= 0) ::close(outer);
    if (inner >= 0) ::close(inner);
  }
  Connection(const Connection&) = delete;
  Connection& operator=(const Connection&) = delete;

  int outer, inner = -1;  // to the client, to the server
  const std::string address;
  Timestamp progress;
  std::unique_ptr<SSL, SslDeleter> ssl;
  std::string to_inner, to_outer;
  bool outer_ended = false, inner_ended = false, wants_write = false;
};

TlsFront::TlsFront(TlsContext context, Take take, const TlsLimits& limits)
    : context_(std::move(context)),
      take_(std::move(take)),
      limits_(limits),
      wake_(eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK)),
      thread_([this] { run(); }) {}

TlsFront::~TlsFront() {
  ending_ = true;
  eventfd_write(wake_, 1);
  thread_.join();
  ::close(wake_);
}

std::size_t TlsFront::connections() const {
  const std::lock_guard lock(mutex_);
  return connections_.size();
}

void TlsFront::add(int socket, std::string address) {
  ::fcntl(socket, F_SETFL, ::fcntl(socket, F_GETFL) | O_NONBLOCK);
  const std::lock_guard lock(mutex_);
  connections_.push_back(std::make_unique<Connection>(socket, std::move(address), monotonicNow()));
  if (connections_.size() > limits_.most) {
    const auto index = oldestOfMost(connections_, [](const auto& one) { return std::string_view(one->address); });
    connections_.erase(connections_.begin() + static_cast<std::ptrdiff_t>(index));
    ++dropped_;
  }
  eventfd_write(wake_, 1);
}

void TlsFront::run() {
  while (!ending_) {
    wait();
    const Timestamp now = monotonicNow();
    const std::lock_guard lock(mutex_);
    std::erase_if(connections_, [&](const auto& connection) { return !serve(*connection, now); });
  }
}

void TlsFront::wait() {
  std::vector<pollfd> waiting{{wake_, POLLIN, 0}};
  {
    const std::lock_guard lock(mutex_);
    for (const auto& one : connections_) {
      const bool reads = !one->outer_ended && one->to_inner.size() < limits_.buffer;
      const bool writes = one->wants_write || !one->to_outer.empty();
      waiting.push_back({reads || writes ? one->outer : -1,  // whose end poll() would name again and again
                         static_cast<short>((reads ? POLLIN : 0) | (writes ? POLLOUT : 0)), 0});
      if (one->inner < 0) continue;
      const bool takes = !one->inner_ended && one->to_outer.size() < limits_.buffer;
      waiting.push_back({takes || !one->to_inner.empty() ? one->inner : -1,
                         static_cast<short>((takes ? POLLIN : 0) | (one->to_inner.empty() ? 0 : POLLOUT)), 0});
    }
  }
  ::poll(waiting.data(), waiting.size(), kLook);
  eventfd_t count = 0;
  eventfd_read(wake_, &count);
}

bool TlsFront::serve(Connection& connection, Timestamp now) {
  ERR_clear_error();
  const bool goes_on = connection.inner >= 0 ? pump(connection, now) : greet(connection, now);
  return goes_on && connection.outer >= 0;
}

/// The handshake, a part of it at a time.
bool TlsFront::greet(Connection& connection, Timestamp now) {
  if (now - connection.progress > limits_.handshake) {
    ++dropped_;
    return false;
  }
  if (!connection.ssl) {
    std::uint8_t first = 0;
    const ssize_t got = ::recv(connection.outer, &first, 1, MSG_PEEK | MSG_DONTWAIT);
    if (got < 0) return isPassing(errno);
    if (got == 0) return false;
    if (first != kHandshakeRecord) {
      take_(std::exchange(connection.outer, -1), connection.address, false);
      return false;
    }
    connection.ssl.reset(SSL_new(context_.context.get()));
    if (!connection.ssl || SSL_set_fd(connection.ssl.get(), connection.outer) != 1) return false;
  }
  const int result = SSL_accept(connection.ssl.get());
  const int error = SSL_get_error(connection.ssl.get(), result);
  connection.wants_write = error == SSL_ERROR_WANT_WRITE;
  if (result != 1) {
    const bool waits = error == SSL_ERROR_WANT_READ || error == SSL_ERROR_WANT_WRITE;
    dropped_ += !waits;
    return waits;
  }
  std::array<int, 2> ends{};
  if (::socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0, ends.data()) != 0) return false;
  connection.inner = ends[0];
  take_(ends[1], connection.address, true);
  return pump(connection, now);
}

/// What has come, in both directions, as far as the buffers have room.
bool TlsFront::pump(Connection& connection, Timestamp now) {
  std::array<char, kPart> part;
  SSL* ssl = connection.ssl.get();
  while (!connection.outer_ended && connection.to_inner.size() < limits_.buffer) {
    const int got = SSL_read(ssl, part.data(), static_cast<int>(part.size()));
    if (got > 0) {
      connection.to_inner.append(part.data(), static_cast<std::size_t>(got));
      continue;
    }
    const int error = SSL_get_error(ssl, got);
    if (error == SSL_ERROR_WANT_READ || error == SSL_ERROR_WANT_WRITE) break;
    if (error != SSL_ERROR_ZERO_RETURN) return false;
    connection.outer_ended = true;
  }
  while (!connection.to_inner.empty()) {
    const ssize_t sent =
        ::send(connection.inner, connection.to_inner.data(), connection.to_inner.size(), MSG_DONTWAIT | MSG_NOSIGNAL);
    if (sent < 0 && !isPassing(errno)) connection.to_inner.clear();  // the server reads no more
    if (sent <= 0) break;
    connection.to_inner.erase(0, static_cast<std::size_t>(sent));
  }
  if (connection.outer_ended && connection.to_inner.empty()) ::shutdown(connection.inner, SHUT_WR);
  while (!connection.inner_ended && connection.to_outer.size() < limits_.buffer) {
    const ssize_t got = ::recv(connection.inner, part.data(), part.size(), MSG_DONTWAIT);
    if (got < 0 && isPassing(errno)) break;
    if (got <= 0) {
      connection.inner_ended = true;
      break;
    }
    connection.to_outer.append(part.data(), static_cast<std::size_t>(got));
  }
  if (connection.to_outer.empty()) connection.progress = now;
  while (!connection.to_outer.empty()) {
    const int sent = SSL_write(ssl, connection.to_outer.data(), static_cast<int>(connection.to_outer.size()));
    if (sent <= 0) {
      const int error = SSL_get_error(ssl, sent);
      if (error != SSL_ERROR_WANT_READ && error != SSL_ERROR_WANT_WRITE) return false;
      break;
    }
    connection.to_outer.erase(0, static_cast<std::size_t>(sent));
    connection.progress = now;
  }
  if (connection.inner_ended && connection.to_outer.empty()) {
    SSL_shutdown(ssl);
    ::shutdown(connection.outer, SHUT_WR);
    return false;
  }
  if (connection.inner_ended && now - connection.progress > limits_.patience) {
    ++dropped_;
    return false;
  }
  return true;
}

}  // namespace slam
