// SPDX-License-Identifier: BSD-3-Clause
#include "bus/udpm/multicast_route.hpp"

#include <cerrno>
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

int openNetlink() { return socket(AF_NETLINK, SOCK_RAW | SOCK_CLOEXEC | SOCK_NONBLOCK, NETLINK_ROUTE); }

/// A socket that gets a message for each change that can move a route; -1 where one may not listen for all of them.
int openChanges() {
  const int descriptor = openNetlink();
  const sockaddr_nl any{.nl_family = AF_NETLINK, .nl_pad = 0, .nl_pid = 0, .nl_groups = 0};
  // Without an address of its own it would get nothing.
  bool listens = bind(descriptor, reinterpret_cast<const sockaddr*>(&any), sizeof any) == 0;
  for (const int group : {RTNLGRP_LINK, RTNLGRP_IPV4_IFADDR, RTNLGRP_IPV4_ROUTE, RTNLGRP_IPV4_RULE,
                          RTNLGRP_IPV4_NETCONF, RTNLGRP_NEXTHOP}) {
    listens = listens && setsockopt(descriptor, SOL_NETLINK, NETLINK_ADD_MEMBERSHIP, &group, sizeof group) == 0;
  }
  if (!listens && descriptor >= 0) close(descriptor);
  return listens ? descriptor : -1;
}

}  // namespace

MulticastRoute::MulticastRoute(const UdpmUrl& url)
    : group_(url.group.sin_addr), questions_(openNetlink()), changes_(openChanges()) {}

MulticastRoute::~MulticastRoute() {
  if (questions_ >= 0) close(questions_);
  if (changes_ >= 0) close(changes_);
}

std::optional<int> MulticastRoute::interface() {
  if (questions_ < 0) return 0;
  // Without a route, or without an answer, it is asked for each time.
  if (mayHaveChanged() || !interface_ || changes_ < 0) interface_ = ask();
  return interface_;
}

/// Reads the reports of changes away; a loss of some (ENOBUFS) is a report, too.
bool MulticastRoute::mayHaveChanged() const {
  constexpr int kMostReports = 64;  // at a time: what is left counts the next time
  bool changed = false;
  char first = 0;  // what has changed is not of interest
  for (int i = 0; i < kMostReports; ++i) {
    if (recv(changes_, &first, sizeof first, MSG_TRUNC) < 0 && errno != ENOBUFS) break;
    changed = true;
  }
  return changed;
}

std::optional<int> MulticastRoute::ask() const {
  Question question{};
  question.head.nlmsg_len = sizeof question;
  question.head.nlmsg_type = RTM_GETROUTE;
  question.head.nlmsg_flags = NLM_F_REQUEST;
  question.route.rtm_family = AF_INET;
  question.route.rtm_dst_len = 32;
  question.attribute.rta_len = RTA_LENGTH(sizeof(in_addr));
  question.attribute.rta_type = RTA_DST;
  question.destination = group_;
  if (send(questions_, &question, sizeof question, 0) != sizeof question) return std::nullopt;
  alignas(nlmsghdr) char buffer[4096];
  const ssize_t size = recv(questions_, buffer, sizeof buffer, 0);
  auto* answer = reinterpret_cast<nlmsghdr*>(buffer);
  return size > 0 && NLMSG_OK(answer, static_cast<std::size_t>(size)) ? interfaceIn(answer) : std::nullopt;
}

}  // namespace slam
