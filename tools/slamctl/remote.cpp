// SPDX-License-Identifier: BSD-3-Clause
#include "tools/slamctl/remote.hpp"

#include <algorithm>
#include <stdexcept>
#include <unistd.h>
#include <utility>

#include "bus/channels.hpp"
#include "bus/multicast_route.hpp"
#include "slam/command_t.hpp"

namespace slam {
namespace {

using Clock = std::chrono::steady_clock;

/// @return nothing for what is not such a message
template <typename Message>
std::optional<Message> decode(const lcm::ReceiveBuffer* buffer) {
  try {
    Message message;
    const bool whole = message.decode(buffer->data, 0, static_cast<int>(buffer->data_size)) >= 0;
    return whole ? std::optional<Message>(std::move(message)) : std::nullopt;
  } catch (const std::exception&) {  // a hostile count asks for more memory than there is
    return std::nullopt;
  }
}

}  // namespace

Remote::Remote(const std::string& url) {
  if (hasMulticastRoute(url)) lcm_.emplace(url);
  if (!lcm_ || !lcm_->good()) {
    throw std::runtime_error(url +
                             ": LCM has no multicast route; mend: ip link set lo multicast on && "
                             "ip route add 224.0.0.0/4 dev lo");
  }
  lcm_->subscribe(channel::kAck, &Remote::onAck, this);
  lcm_->subscribe(channel::kHealth, &Remote::onHealth, this);
}

void Remote::onAck(const lcm::ReceiveBuffer* buffer, const std::string&) {
  if (auto ack = decode<ack_t>(buffer)) ack_ = std::move(*ack);
}

void Remote::onHealth(const lcm::ReceiveBuffer* buffer, const std::string&) {
  if (auto health = decode<health_t>(buffer)) health_ = std::move(*health);
}

template <typename Done>
void Remote::handleUntil(std::chrono::milliseconds limit, Done&& done) {
  const auto end = Clock::now() + limit;
  while (!done() && Clock::now() < end) {
    const auto left = std::chrono::duration_cast<std::chrono::milliseconds>(end - Clock::now());
    lcm_->handleTimeout(static_cast<int>(std::max<std::int64_t>(1, left.count())));
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
  if (lcm_->publish(channel::kCommand, &command) != 0) throw std::runtime_error("the command could not be sent");
  handleUntil(limit, [&] { return ack_ && ack_->id == command.id; });
  return ack_ && ack_->id == command.id ? ack_ : std::nullopt;
}

std::optional<health_t> Remote::health(std::chrono::milliseconds limit) {
  handleUntil(limit, [&] { return health_.has_value(); });
  return health_;
}

}  // namespace slam
