// SPDX-License-Identifier: BSD-3-Clause
#include "tools/sim/depth_server.hpp"

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <poll.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <system_error>
#include <unistd.h>

#include "runtime/clock.hpp"

namespace slam::sim {
namespace {

using namespace std::chrono_literals;
constexpr Duration kRequestTimeout = 1s;  // a client that has not asked by then is sent away

/// @return events that came, 0 after the limit
short wait(int descriptor, short events, Duration limit) {
  pollfd entry{descriptor, events, 0};
  const auto nanoseconds = std::max<Duration::rep>(0, limit.count());
  const timespec timeout{nanoseconds / 1000000000, nanoseconds % 1000000000};
  return ppoll(&entry, 1, &timeout, nullptr) > 0 ? entry.revents : short{0};
}

[[noreturn]] void fail(const std::filesystem::path& path) {
  throw std::system_error(errno, std::generic_category(), path.string());
}

}  // namespace

DepthServer::DepthServer(const std::filesystem::path& path, const World& world, std::uint64_t seed,
                         DepthStream::Viewpoint viewpoint)
    : path_(path), world_(world), seed_(seed), viewpoint_(std::move(viewpoint)) {
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  errno = ENAMETOOLONG;
  if (path.native().size() >= sizeof address.sun_path) fail(path);
  std::memcpy(address.sun_path, path.c_str(), path.native().size());
  std::filesystem::create_directories(path.parent_path());
  unlink(path.c_str());
  listener_ = socket(AF_UNIX, SOCK_STREAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0);
  if (listener_ < 0) fail(path);
  if (bind(listener_, reinterpret_cast<const sockaddr*>(&address), sizeof address) != 0 || listen(listener_, 4) != 0) {
    const int error = errno;
    close(listener_);
    errno = error;
    fail(path);
  }
}

DepthServer::~DepthServer() {
  dropClient();
  close(listener_);
  unlink(path_.c_str());
}

void DepthServer::dropClient() {
  if (client_ >= 0) close(client_);
  client_ = -1;
  stream_.reset();
  out_.clear();
}

void DepthServer::serve(Duration limit) {
  if (client_ < 0) return accept(limit);
  if (!stream_) return readRequest(limit);
  stream(limit);
}

void DepthServer::accept(Duration limit) {
  if (wait(listener_, POLLIN, limit) == 0) return;
  client_ = accept4(listener_, nullptr, nullptr, SOCK_NONBLOCK | SOCK_CLOEXEC);
  accepted_ = monotonicNow();
}

void DepthServer::readRequest(Duration limit) {
  if (wait(client_, POLLIN, limit) == 0) {
    if (monotonicNow() > accepted_ + kRequestTimeout) dropClient();
    return;
  }
  // 16 bytes in one write arrive in one piece on a local socket; anything else is no request.
  DepthModeRequest request;
  const bool whole = recv(client_, &request, sizeof request, 0) == static_cast<ssize_t>(sizeof request);
  if (!whole || request.magic != DepthModeRequest::kMagic ||
      !isDepthMode(request.width, request.height, request.rate)) {
    return dropClient();
  }
  const DepthMode mode{static_cast<int>(request.width), static_cast<int>(request.height),
                       static_cast<int>(request.rate)};
  stream_.emplace(world_, mode, seed_, monotonicNow(), viewpoint_);
}

void DepthServer::stream(Duration limit) {
  const Timestamp now = monotonicNow();
  stream_->capture(now);
  if (out_.empty()) {
    out_ = stream_->take(now);
    sent_ = 0;
  }
  const auto events = static_cast<short>(out_.empty() ? POLLIN : POLLIN | POLLOUT);
  // While a frame is on its way, the next one waits in the stream.
  const Timestamp next = out_.empty() ? stream_->next() : std::max(stream_->next(), now + 1ms);
  const short came = wait(client_, events, std::min(limit, next - now));
  if (came & (POLLIN | POLLHUP | POLLERR)) return dropClient();  // it has nothing more to say: it is gone
  if (came & POLLOUT) send();
}

void DepthServer::send() {
  const ssize_t taken = ::send(client_, out_.data() + sent_, out_.size() - sent_, MSG_NOSIGNAL | MSG_DONTWAIT);
  if (taken < 0 && errno != EAGAIN && errno != EINTR) return dropClient();
  sent_ += static_cast<std::size_t>(std::max<ssize_t>(taken, 0));
  if (sent_ == out_.size()) out_.clear();
}

}  // namespace slam::sim
