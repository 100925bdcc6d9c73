// SPDX-License-Identifier: BSD-3-Clause
#include "tools/web/event_hub.hpp"

#include <cerrno>
#include <string_view>
#include <sys/socket.h>
#include <unistd.h>

#include "tools/web/oldest_of_most.hpp"

namespace slam {

EventHub::~EventHub() {
  for (const Reader& reader : readers_) ::close(reader.socket);
}

void EventHub::add(int socket, std::string greeting, Timestamp now, std::string address) {
  const std::lock_guard lock(mutex_);
  Reader reader{socket, std::move(greeting), now, std::move(address)};
  if (!push(reader, now)) {
    ::close(socket);
    return;
  }
  readers_.push_back(std::move(reader));
  if (readers_.size() > kMostReaders) makePlace();
}

void EventHub::makePlace() {
  const auto index = oldestOfMost(readers_, [](const Reader& reader) { return std::string_view(reader.address); });
  ::close(readers_[index].socket);
  readers_.erase(readers_.begin() + static_cast<std::ptrdiff_t>(index));
  ++dropped_;
}

void EventHub::send(const std::string& text, Timestamp now) {
  const std::lock_guard lock(mutex_);
  std::erase_if(readers_, [&](Reader& reader) {
    reader.unsent += text;
    if (push(reader, now)) return false;
    ::close(reader.socket);
    return true;
  });
}

bool EventHub::push(Reader& reader, Timestamp now) {
  // Nothing is expected of a reader any more; what it sends all the same is thrown away.
  char ignored[512];
  const ssize_t heard = ::recv(reader.socket, ignored, sizeof ignored, MSG_DONTWAIT);
  if (heard == 0 || (heard < 0 && errno != EAGAIN && errno != EINTR)) return false;
  const ssize_t sent = reader.unsent.empty() ? 0
                                             : ::send(reader.socket, reader.unsent.data(), reader.unsent.size(),
                                                      MSG_DONTWAIT | MSG_NOSIGNAL);
  if (sent < 0 && errno != EAGAIN && errno != EINTR) return false;
  if (sent > 0) {
    reader.unsent.erase(0, static_cast<std::size_t>(sent));
    reader.progress = now;
  }
  if (reader.unsent.empty()) reader.progress = now;
  const bool slow = reader.unsent.size() > kMostUnsent || now - reader.progress > kPatience;
  dropped_ += slow;
  return !slow;
}

std::size_t EventHub::readers() const {
  const std::lock_guard lock(mutex_);
  return readers_.size();
}

std::uint64_t EventHub::dropped() const {
  const std::lock_guard lock(mutex_);
  return dropped_;
}

}  // namespace slam
