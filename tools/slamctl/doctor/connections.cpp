// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cerrno>
#include <chrono>
#include <cstdint>
#include <cstring>
#include <grp.h>
#include <poll.h>
#include <pwd.h>
#include <span>
#include <unistd.h>

#include "bus/local_client.hpp"
#include "bus/udpm/lcm_link.hpp"
#include "runtime/clock.hpp"
#include "tools/slamctl/doctor.hpp"

namespace slam {
namespace {

constexpr Duration kEchoLimit = std::chrono::seconds(3);
constexpr int kEchoPeriod = 100;  // [ms]
constexpr auto kRouteUnits = {"/usr/lib/systemd/system/slamd-multicast.service",
                              "/usr/local/lib/systemd/system/slamd-multicast.service"};

/// Whether the system's list has this user in the group; a session has the groups of its beginning.
bool isMember(const char* name) {
  const passwd* user = getpwuid(getuid());
  const std::string own = user != nullptr ? user->pw_name : "";
  const group* found = getgrnam(name);
  if (found == nullptr) return false;
  for (char** member = found->gr_mem; *member != nullptr; ++member) {
    if (own == *member) return true;
  }
  return false;
}

}  // namespace

Finding checkSocket(const std::string& path) {
  const std::string name = "socket: " + path;
  switch (const int error = LocalClient::probe(path)) {
    case 0:
      return {Finding::kGood, name + " takes commands", ""};
    case EACCES:
      return {Finding::kFault, name + " is not open to this user, who is not in group " + LocalClient::kGroup,
              isMember(LocalClient::kGroup)
                  ? "log in again: the group has been given since"
                  : std::string("sudo usermod -aG ") + LocalClient::kGroup + " $USER, and log in again"};
    case EAGAIN:
      return {Finding::kFault, name + ": slamd does not take in who connects: it hangs, or the computer is overloaded",
              "see what is said of slamd below; else sudo systemctl restart slamd"};
    case ENOENT:
    case ECONNREFUSED:
      return {Finding::kWarning, name + ": slamd does not run",
              "sudo systemctl start slamd; journalctl -u slamd -n 50 tells why it ended"};
    default:
      return {Finding::kFault, name + ": " + std::strerror(error), "set runtime.socket, and restart slamd"};
  }
}

Finding checkLcm(const std::string& url) {
  LcmLink link(url);
  const std::string channel = "SLAM_DOCTOR_" + std::to_string(getpid());
  const std::vector<std::uint8_t> sent(60000, 0x5A);  // about as large as messages get
  bool returned = false;
  link.subscribe(channel, [&](std::span<const std::uint8_t> data) {
    returned = std::equal(data.begin(), data.end(), sent.begin(), sent.end());
  });
  const Timestamp end = monotonicNow() + kEchoLimit;
  while (!returned && !isFault(link.state(monotonicNow())) && monotonicNow() < end) {
    link.tend(monotonicNow());
    link.publish(channel, sent, monotonicNow());
    pollfd waiting{link.descriptor(), POLLIN, 0};
    ::poll(&waiting, 1, kEchoPeriod);
    link.receive();
  }
  if (returned) return {Finding::kGood, "LCM: " + url + " carries messages", ""};
  const LinkState seen = link.state(monotonicNow());
  const LinkState state = isFault(seen) ? seen : LinkState::kNoLoopback;
  const Problem problem = problemOf(state, link.url());
  std::string fix = problem.fix();
  const bool has_unit = std::any_of(kRouteUnits.begin(), kRouteUnits.end(), [](const char* unit) {
    std::error_code ignored;
    return std::filesystem::exists(unit, ignored);
  });
  if (state == LinkState::kNoRoute && link.url().ttl == 0 && has_unit)
    fix = "sudo systemctl restart slamd-multicast, or " + fix;
  return {Finding::kFault, "LCM: " + problem.cause() + " (" + url + ")", fix};
}

}  // namespace slam
