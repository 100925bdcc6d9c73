// SPDX-License-Identifier: BSD-3-Clause
#include "bus/udpm/multicast_route.hpp"

#include <cstring>
#include <linux/rtnetlink.h>
#include <sys/socket.h>
#include <unistd.h>

namespace slam {
namespace {

struct Question {
  nlmsghdr head;
  rtmsg route;
  rtattr attribute;
  in_addr destination;
};
static_assert(sizeof(Question) == NLMSG_LENGTH(sizeof(rtmsg)) + RTA_LENGTH(sizeof(in_addr)));

/// The interface in an answer, which is an error without a route.
std::optional<int> interfaceIn(nlmsghdr* answer) {
  if (answer->nlmsg_type != RTM_NEWROUTE) return std::nullopt;
  auto* attribute = RTM_RTA(NLMSG_DATA(answer));
  for (auto left = RTM_PAYLOAD(answer); RTA_OK(attribute, left); attribute = RTA_NEXT(attribute, left)) {
    if (attribute->rta_type != RTA_OIF) continue;
    int index = 0;
    std::memcpy(&index, RTA_DATA(attribute), sizeof index);
    return index;
  }
  return std::nullopt;
}

}  // namespace

MulticastRoute::MulticastRoute(const UdpmUrl& url)
    : group_(url.group.sin_addr), socket_(socket(AF_NETLINK, SOCK_RAW | SOCK_CLOEXEC | SOCK_NONBLOCK, NETLINK_ROUTE)) {}

MulticastRoute::~MulticastRoute() {
  if (socket_ >= 0) close(socket_);
}

std::optional<int> MulticastRoute::interface() const {
  if (socket_ < 0) return 0;
  Question question{};
  question.head.nlmsg_len = sizeof question;
  question.head.nlmsg_type = RTM_GETROUTE;
  question.head.nlmsg_flags = NLM_F_REQUEST;
  question.route.rtm_family = AF_INET;
  question.route.rtm_dst_len = 32;
  question.attribute.rta_len = RTA_LENGTH(sizeof(in_addr));
  question.attribute.rta_type = RTA_DST;
  question.destination = group_;
  if (send(socket_, &question, sizeof question, 0) != sizeof question) return std::nullopt;
  alignas(nlmsghdr) char buffer[4096];
  const ssize_t size = recv(socket_, buffer, sizeof buffer, 0);
  auto* answer = reinterpret_cast<nlmsghdr*>(buffer);
  return size > 0 && NLMSG_OK(answer, static_cast<std::size_t>(size)) ? interfaceIn(answer) : std::nullopt;
}

}  // namespace slam
