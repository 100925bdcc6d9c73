// SPDX-License-Identifier: BSD-3-Clause
#include "tools/sim/depth/depth_server.hpp"

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
constexpr std::size_t kDelayedFrames = 128;
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
  std::filesystem::create_directories(path.parent_path());
  listen();
}

void DepthServer::listen() {
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  errno = ENAMETOOLONG;
  if (path_.native().size() >= sizeof address.sun_path) fail(path_);
  std::memcpy(address.sun_path, path_.c_str(), path_.native().size());
  unlink(path_.c_str());
  listener_ = socket(AF_UNIX, SOCK_STREAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0);
  if (listener_ < 0) fail(path_);
  if (bind(listener_, reinterpret_cast<const sockaddr*>(&address), sizeof address) != 0 ||
      ::listen(listener_, 4) != 0) {
    const int error = errno;
    close(listener_);
    errno = error;
    fail(path_);
  }
}

void DepthServer::unplug() {
  dropClient();
  if (listener_ >= 0) close(listener_);
  listener_ = -1;
  unlink(path_.c_str());
}

DepthServer::~DepthServer() { unplug(); }

bool DepthServer::inject(std::string_view kind, double value) {
  const bool was_unplugged = faults_.unplugged();
  if (!faults_.inject(kind, value)) return false;
  if (faults_.unplugged() && !was_unplugged) unplug();
  if (!faults_.unplugged() && was_unplugged) listen();
  return true;
}

void DepthServer::dropClient() {
  if (client_ >= 0) close(client_);
  client_ = -1;
  stream_.reset();
  delayed_.clear();
  out_.clear();
}

void DepthServer::serve(Duration limit) {
  if (faults_.unplugged()) {
    poll(nullptr, 0, static_cast<int>(limit / 1ms));
    return;
  }
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
  takeFrame(now);
  const auto events = static_cast<short>(out_.empty() ? POLLIN : POLLIN | POLLOUT);
  // While a frame is on its way, the next one waits in the stream.
  Timestamp next = out_.empty() ? stream_->next() : std::max(stream_->next(), now + 1ms);
  if (out_.empty() && !delayed_.empty()) next = std::min(next, delayed_.front().due);
  const short came = wait(client_, events, std::min(limit, next - now));
  if (came & (POLLIN | POLLHUP | POLLERR)) return dropClient();  // it has nothing more to say: it is gone
  if (came & POLLOUT) send();
}

void DepthServer::takeFrame(Timestamp now) {
  // While a frame is on its way the next ones wait in the stream, which loses some as the device would; but a line that
  // delays holds many.
  const bool room = faults_.delay() > Duration(0) ? delayed_.size() < kDelayedFrames : out_.empty() && delayed_.empty();
  if (room) {
    std::vector<std::uint8_t> frame = stream_->take(now);
    if (!frame.empty() && faults_.spoil(frame)) delayed_.push_back({now + faults_.delay(), std::move(frame)});
  }
  if (!out_.empty() || delayed_.empty() || delayed_.front().due > now) return;
  out_ = std::move(delayed_.front().bytes);
  delayed_.pop_front();
  sent_ = 0;
}

void DepthServer::send() {
  const ssize_t taken = ::send(client_, out_.data() + sent_, out_.size() - sent_, MSG_NOSIGNAL | MSG_DONTWAIT);
  if (taken < 0 && errno != EAGAIN && errno != EINTR) return dropClient();
  sent_ += static_cast<std::size_t>(std::max<ssize_t>(taken, 0));
  if (sent_ == out_.size()) out_.clear();
}

}  // namespace slam::sim
