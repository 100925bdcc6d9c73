// SPDX-License-Identifier: BSD-3-Clause
#include "tools/web/event_hub.hpp"

#include <cerrno>
#include <sys/socket.h>
#include <unistd.h>

namespace slam {

EventHub::~EventHub() {
  for (const Reader& reader : readers_) ::close(reader.socket);
}

bool EventHub::hasRoom() const {
  const std::lock_guard lock(mutex_);
  return readers_.size() < kMostReaders;
}

bool EventHub::add(int socket, std::string greeting, Timestamp now) {
  const std::lock_guard lock(mutex_);
  Reader reader{socket, std::move(greeting), now};
  if (readers_.size() >= kMostReaders || !push(reader, now)) {
    ::close(socket);
    return false;
  }
  readers_.push_back(std::move(reader));
  return true;
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
