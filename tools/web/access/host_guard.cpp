// SPDX-License-Identifier: BSD-3-Clause
#include "tools/web/access/host_guard.hpp"

#include <algorithm>
#include <chrono>

#include "runtime/clock.hpp"
#include "tools/web/access/token_gate.hpp"
#include "tools/web/request_guard.hpp"

namespace slam {
namespace {

constexpr Duration kNamesAge = std::chrono::seconds(5);

}  // namespace

bool HostGuard::mayEnter(const httplib::Request& request, httplib::Response& response) const {
  const auto host =
      request.get_header_value_count("Host") == 1 ? hostOf(request.get_header_value("Host")) : std::nullopt;
  if (!host) {
    refuse(response, 400, "one Host header is needed, with a name or an address");
    return false;
  }
  if (isOwnHost(*host)) return true;
  refuse(response, 421, "this is not that host; use the robot's address or name, or set web.address to the name");
  return false;
}

bool HostGuard::isOwnHost(const std::string& host) const {
  const std::lock_guard lock(mutex_);
  const auto isOwn = [&] { return std::find(names_.begin(), names_.end(), host) != names_.end(); };
  if (isOwn()) return true;
  const Timestamp now = monotonicNow();
  if (names_.empty() || now > named_ + kNamesAge) {  // addresses come and go with networks
    names_ = ownNames(address_);
    named_ = now;
  }
  return isOwn();
}

}  // namespace slam
