// SPDX-License-Identifier: BSD-3-Clause
#include "bus/udpm/lcm_sender.hpp"

#include <cerrno>
#include <utility>

namespace slam {

LcmSender::~LcmSender() {
  delete next_.load();
  delete used_.load();
}

void LcmSender::open(int interface) {
  auto lcm = std::make_unique<lcm::LCM>(url_.text);
  if (lcm->good()) hand(std::make_unique<Socket>(Socket{std::move(lcm), interface}));
}

void LcmSender::close() { hand(std::make_unique<Socket>()); }

void LcmSender::collect() { delete used_.exchange(nullptr); }

void LcmSender::hand(std::unique_ptr<Socket> next) {
  collect();
  delete next_.exchange(next.release());
}

void LcmSender::take() {
  if (used_.load() != nullptr) return;  // the one before is not collected yet
  Socket* const next = next_.exchange(nullptr);
  if (next == nullptr) return;
  used_.store(socket_.release());
  socket_.reset(next);
}

LcmSender::Outcome LcmSender::publish(const std::string& channel, std::span<const std::uint8_t> data) {
  take();
  if (!socket_ || !socket_->lcm) return {};
  // With a TTL of 0, see LcmLink.
  if (url_.ttl == 0 && route_.interface() != socket_->interface) return {};
  errno = 0;
  const bool sent = socket_->lcm->publish(channel, data.data(), static_cast<unsigned>(data.size())) == 0;
  return {sent, sent ? 0 : errno};
}

}  // namespace slam
