// SPDX-License-Identifier: BSD-3-Clause
#include "tools/sim/openni2/frame_source.hpp"

#include <cerrno>
#include <cstring>
#include <poll.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

namespace slam::sim {
namespace {

/// @return descriptor, -1 when nobody listens. Never waits for a server that is busy with another client.
int connectTo(const std::string& path) {
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  if (path.size() >= sizeof address.sun_path) return -1;
  std::memcpy(address.sun_path, path.c_str(), path.size());
  const int descriptor = socket(AF_UNIX, SOCK_STREAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0);
  if (descriptor < 0) return -1;
  if (connect(descriptor, reinterpret_cast<const sockaddr*>(&address), sizeof address) == 0) return descriptor;
  const int error = errno;
  ::close(descriptor);
  errno = error;
  return -1;
}

}  // namespace

bool isServed(const std::string& path) {
  const int descriptor = connectTo(path);
  if (descriptor < 0) return errno == EAGAIN;  // its queue is full
  close(descriptor);
  return true;
}

bool FrameSource::open(const std::string& path, const DepthMode& mode) {
  close();
  mode_ = mode;
  descriptor_ = connectTo(path);
  if (descriptor_ < 0) return false;
  const DepthModeRequest request{.width = static_cast<std::uint32_t>(mode.width),
                                 .height = static_cast<std::uint32_t>(mode.height),
                                 .rate = static_cast<std::uint32_t>(mode.rate)};
  return send(descriptor_, &request, sizeof request, MSG_NOSIGNAL) == static_cast<ssize_t>(sizeof request);
}

bool FrameSource::receive(void* data, std::size_t size) {
  auto* at = static_cast<std::uint8_t*>(data);
  while (size > 0) {
    const ssize_t taken = recv(descriptor_, at, size, 0);
    if (taken == 0 || (taken < 0 && errno != EINTR && errno != EAGAIN)) return false;
    if (taken < 0) {
      pollfd entry{descriptor_, POLLIN, 0};
      poll(&entry, 1, -1);  // interrupt() ends this too
      continue;
    }
    at += taken;
    size -= static_cast<std::size_t>(taken);
  }
  return true;
}

bool FrameSource::read(DepthFrameHeader& header, std::vector<std::uint16_t>& pixels) {
  if (descriptor_ < 0 || !receive(&header, sizeof header)) return false;
  const auto width = static_cast<std::uint32_t>(mode_.width), height = static_cast<std::uint32_t>(mode_.height);
  if (header.magic != DepthFrameHeader::kMagic || header.width != width || header.height != height ||
      header.size != width * height * sizeof(std::uint16_t)) {
    return false;
  }
  pixels.resize(static_cast<std::size_t>(width) * height);
  return receive(pixels.data(), header.size);
}

void FrameSource::interrupt() {
  if (descriptor_ >= 0) shutdown(descriptor_, SHUT_RDWR);
}

void FrameSource::close() {
  if (descriptor_ >= 0) ::close(descriptor_);
  descriptor_ = -1;
}

}  // namespace slam::sim
