// SPDX-License-Identifier: BSD-3-Clause
#include "tools/slamctl/remote.hpp"

#include <algorithm>
#include <poll.h>
#include <stdexcept>
#include <unistd.h>
#include <utility>
#include <vector>

#include "bus/channels.hpp"
#include "bus/checked_decode.hpp"
#include "runtime/clock.hpp"

namespace slam {
namespace {

constexpr int kLongestWait = 100;  // [ms] after it, the link is tended

}  // namespace

Remote::Remote(const std::string& url) : link_(url) {
  link_.tend(monotonicNow());
  refuseFault();
  link_.subscribe(channel::kAck, [this](std::span<const std::uint8_t> data) {
    if (auto ack = decodeChecked<ack_t>(data)) ack_ = std::move(*ack);
  });
  link_.subscribe(channel::kHealth, [this](std::span<const std::uint8_t> data) {
    if (auto health = decodeChecked<health_t>(data)) health_ = std::move(*health);
  });
}

void Remote::refuseFault() const {
  const LinkState state = link_.state(monotonicNow());
  if (!isFault(state)) return;
  throw std::runtime_error(link_.url().text + ": LCM: " + causeOf(state, link_.url()) +
                           "; fix: " + fixOf(state, link_.url()));
}

template <typename Done>
void Remote::handleUntil(std::chrono::milliseconds limit, Done&& done) {
  const Timestamp end = monotonicNow() + limit;
  while (!done() && monotonicNow() < end) {
    link_.tend(monotonicNow());
    pollfd waiting{link_.descriptor(), POLLIN, 0};
    ::poll(&waiting, 1, kLongestWait);
    link_.receive();
  }
}

std::optional<ack_t> Remote::ask(const std::string& verb, const std::string& argument,
                                 const std::array<double, 3>& pose, std::chrono::milliseconds limit) {
  command_t command{};
  const auto now = std::chrono::system_clock::now().time_since_epoch();
  command.utime = std::chrono::duration_cast<std::chrono::microseconds>(now).count();
  command.id = static_cast<std::int32_t>((command.utime / 1000) ^ (::getpid() << 8)) & 0x7FFFFFFF;
  command.verb = verb;
  command.argument = argument;
  std::copy(pose.begin(), pose.end(), command.pose);
  std::vector<std::uint8_t> bytes(static_cast<std::size_t>(command.getEncodedSize()));
  command.encode(bytes.data(), 0, static_cast<int>(bytes.size()));
  if (!link_.publish(channel::kCommand, bytes, monotonicNow())) {
    throw std::runtime_error("the command could not be sent; slamctl doctor looks for the cause");
  }
  handleUntil(limit, [&] { return ack_ && ack_->id == command.id; });
  if (ack_ && ack_->id == command.id) return ack_;
  refuseFault();
  return std::nullopt;
}

std::optional<health_t> Remote::health(std::chrono::milliseconds limit) {
  handleUntil(limit, [&] { return health_.has_value(); });
  return health_;
}

}  // namespace slam
