// SPDX-License-Identifier: BSD-3-Clause
#include "tools/web/http_connection.hpp"

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <poll.h>
#include <sys/socket.h>

#include "runtime/clock.hpp"

namespace slam {

HttpConnection::HttpConnection(int socket, const Limits& limits, std::string address, std::function<bool()> isCrowded)
    : socket_(socket),
      limits_(limits),
      address_(std::move(address)),
      isCrowded_(std::move(isCrowded)),
      read_by_(monotonicNow() + limits.request) {}

bool HttpConnection::wait(short event, Timestamp deadline) const {
  using std::chrono::milliseconds;
  for (;;) {
    const auto left = std::chrono::duration_cast<milliseconds>(deadline - monotonicNow()).count();
    if (left <= 0) return false;
    pollfd waiting{socket_, event, 0};
    const int ready = ::poll(&waiting, 1, static_cast<int>(left));
    if (ready > 0) return true;  // or an error, which the call behind finds
    if (ready < 0 && errno != EINTR) return false;
  }
}

Timestamp HttpConnection::answerDeadline() const {
  return answered_ + limits_.answer + fromSeconds(static_cast<double>(sent_) / limits_.least_rate);
}

/// Who takes nothing for a while has to go when others want its thread.
bool HttpConnection::waitForRoom() const {
  for (;;) {
    const Timestamp now = monotonicNow(), end = answerDeadline();
    if (wait(POLLOUT, std::min(end, now + limits_.crowded / 2))) return true;
    if (monotonicNow() >= end) return false;
    if (isCrowded_ && isCrowded_() && monotonicNow() - progress_ >= limits_.crowded) return false;
  }
}

bool HttpConnection::is_readable() const { return begin_ < end_ || wait(POLLIN, read_by_); }

bool HttpConnection::is_writable() const { return answered_ == Timestamp{} || waitForRoom(); }

ssize_t HttpConnection::read(char* bytes, std::size_t size) {
  while (begin_ == end_) {
    if (taken_ >= limits_.request_size || !wait(POLLIN, read_by_)) return -1;
    const std::size_t room = std::min(buffer_.size(), limits_.request_size - taken_);
    const ssize_t got = ::recv(socket_, buffer_.data(), room, MSG_DONTWAIT);
    if (got == 0) return 0;
    if (got < 0 && errno != EAGAIN && errno != EINTR) return -1;
    begin_ = 0;
    end_ = static_cast<std::size_t>(std::max<ssize_t>(got, 0));
    taken_ += end_;
  }
  const std::size_t count = std::min(size, end_ - begin_);
  std::memcpy(bytes, buffer_.data() + begin_, count);
  begin_ += count;
  return static_cast<ssize_t>(count);
}

ssize_t HttpConnection::write(const char* bytes, std::size_t size) {
  if (answered_ == Timestamp{}) answered_ = progress_ = monotonicNow();
  while (waitForRoom()) {
    const ssize_t sent = ::send(socket_, bytes, size, MSG_DONTWAIT | MSG_NOSIGNAL);
    if (sent < 0 && (errno == EAGAIN || errno == EINTR)) continue;
    if (sent > 0) {
      sent_ += static_cast<std::size_t>(sent);
      progress_ = monotonicNow();
    }
    return sent;
  }
  return -1;
}

}  // namespace slam
