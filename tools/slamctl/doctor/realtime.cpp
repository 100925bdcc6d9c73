// SPDX-License-Identifier: BSD-3-Clause
#include "runtime/realtime.hpp"

#include <algorithm>
#include <cerrno>
#include <cstdint>
#include <limits>
#include <sstream>
#include <sys/resource.h>
#include <thread>
#include <unistd.h>

#include "drivers/open_problem.hpp"
#include "runtime/process_usage.hpp"
#include "tools/slamctl/doctor.hpp"

namespace slam {
namespace {

constexpr std::uint64_t kEnoughLocked = 512U << 20;  // [bytes] of memory
constexpr std::uint64_t kUnlimited = std::numeric_limits<std::uint64_t>::max();

/// How the limits of who runs slamd are raised. @param unit setting of the unit @param shell line of limits.d
std::string limitFix(const Account& slamd, const std::string& unit, const std::string& shell) {
  if (slamd.is_service)
    return "sudo systemctl edit slamd, write " + unit + " into [Service], and sudo systemctl restart slamd";
  const bool is_caller = slamd.source == Account::kCaller;
  return "run slamd as a service, or: echo \"" + (is_caller ? "$USER" : slamd.userName()) + " - " + shell +
         "\" | sudo tee -a /etc/security/limits.d/slamd.conf, and log in again" +
         (is_caller ? "" : "; then start slamd again");
}

/// A limit as systemd and /proc write it: a number with or without K, M, G or T, of a soft and a hard one the first.
std::uint64_t limitOf(const std::string& text) {
  if (text.starts_with("infinity") || text.starts_with("unlimited")) return kUnlimited;
  std::istringstream in(text);
  std::uint64_t value = 0;
  char unit = '\0';
  in >> value >> unit;
  const auto power = std::string_view("KMGT").find(unit);
  return power == std::string_view::npos ? value : value << (10U * (power + 1));
}

Finding fifoFinding(const std::string& begin, int priority, const FifoRights& rights, const Account& slamd) {
  const Problem problem = fifoProblem(EPERM, priority, rights);
  const bool by_limit = !rights.privileged && rights.limit < priority;
  return {Finding::kWarning, "real time: " + begin + problem.cause(),
          by_limit ? limitFix(slamd, "LimitRTPRIO=95", "rtprio 95") : problem.fix()};
}

Finding lockFinding(const std::string& begin, const Account& slamd) {
  return {Finding::kWarning, "real time: " + begin, limitFix(slamd, "LimitMEMLOCK=infinity", "memlock unlimited")};
}

Findings checkRealtimeOfProcess(int priority, const Account& slamd, const std::filesystem::path& root) {
  const FifoRights rights = fifoRights(root, slamd.id);
  const int threads = fifoThreads(slamd.id, root);
  const bool may = rights.privileged || rights.limit >= priority;
  Findings findings;
  if (threads > 0 && may) {
    findings.push_back({Finding::kGood,
                        "real time: " + std::to_string(threads) + " threads of " + slamd.words() + " have SCHED_FIFO",
                        ""});
  } else {
    findings.push_back(fifoFinding(slamd.words() + ": ", priority, rights, slamd));
  }
  const auto kilobytes = [&](std::string_view name) { return limitOf(processValue(slamd.id, "status", name, root)); };
  const std::uint64_t locked = kilobytes("VmLck:"),
                      limit = limitOf(processValue(slamd.id, "limits", "Max locked memory", root));
  if (locked == 0) {
    findings.push_back(lockFinding(
        slamd.words() + " has no memory locked; " +
            (limit == kUnlimited ? "it may lock all" : "only " + std::to_string(limit >> 20U) + " MiB may be"),
        slamd));
  } else if (limit != kUnlimited && geteuid() != 0 && slamd.user != 0) {
    findings.push_back(lockFinding(slamd.words() + " has " + std::to_string(locked >> 10U) +
                                       " MiB of its memory locked; what it takes from now on is not, for only " +
                                       std::to_string(limit >> 20U) + " MiB may be",
                                   slamd));
  } else {
    findings.push_back(
        {Finding::kGood,
         "real time: " + slamd.words() + " has " + std::to_string(locked >> 10U) + " MiB of its memory locked", ""});
  }
  return findings;
}

Findings checkRealtimeOfUnit(int priority, const Account& slamd) {
  Findings findings;
  const std::uint64_t fifo = limitOf(slamd.unit.priority_limit), lock = limitOf(slamd.unit.lock_limit);
  const FifoRights rights{.limit = static_cast<int>(std::min<std::uint64_t>(fifo, 99)),
                          .privileged = slamd.user == 0,
                          .filtered = slamd.unit.realtime_refused};
  if (slamd.unit.realtime_refused) {
    findings.push_back({Finding::kWarning, "real time: " + slamd.words() + " may not use SCHED_FIFO",
                        "sudo systemctl edit slamd, write RestrictRealtime=no into [Service]"});
  } else if (rights.privileged || rights.limit >= priority) {
    findings.push_back({Finding::kGood, "real time: " + slamd.words() + " may use SCHED_FIFO", ""});
  } else {
    findings.push_back(fifoFinding(slamd.words() + ": ", priority, rights, slamd));
  }
  if (slamd.user == 0 || lock >= kEnoughLocked) {
    findings.push_back({Finding::kGood, "real time: " + slamd.words() + " may lock its memory", ""});
  } else {
    findings.push_back(
        lockFinding(slamd.words() + " may not lock its memory: its limit is " + slamd.unit.lock_limit, slamd));
  }
  return findings;
}

Findings checkRealtimeOfCaller(int priority, const Account& slamd) {
  Problem refused;
  std::thread([&] { refused = setFifoPriority(priority); }).join();
  Findings findings;
  if (!refused) {
    findings.push_back({Finding::kGood, "real time: SCHED_FIFO is permitted", ""});
  } else {
    findings.push_back(fifoFinding("", priority, fifoRights(), slamd));
  }
  rlimit limit{};
  getrlimit(RLIMIT_MEMLOCK, &limit);
  if (geteuid() == 0 || limit.rlim_cur >= kEnoughLocked) {
    findings.push_back({Finding::kGood, "real time: memory may be locked", ""});
  } else {
    findings.push_back(lockFinding("this user may not lock its memory", slamd));
  }
  return findings;
}

}  // namespace

Findings checkRealtime(int priority, const Account& slamd, const std::filesystem::path& root) {
  switch (slamd.source) {
    case Account::kProcess:
      return checkRealtimeOfProcess(priority, slamd, root);
    case Account::kUnit:
      return checkRealtimeOfUnit(priority, slamd);
    default:
      return checkRealtimeOfCaller(priority, slamd);
  }
}

}  // namespace slam
