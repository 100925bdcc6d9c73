// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <chrono>
#include <ctime>
#include <sys/timex.h>

#include "runtime/process_usage.hpp"
#include "tools/slamctl/doctor.hpp"
#include "tools/slamctl/doctor/number.hpp"

namespace slam {
namespace {

constexpr double kRateTolerance = 0.7;  // [1] of the expected rate
constexpr std::time_t kYear2024 = 1704067200;
constexpr Duration kClockSetBack = std::chrono::milliseconds(500);  // more than a clock is slewed by

}  // namespace

std::optional<Finding> checkLoad(const CpuWaits& before, const CpuWaits& after, Duration between) {
  constexpr double kMuch = 0.5;  // [1] of the time
  const CpuWait* worst = nullptr;
  double most = kMuch;
  for (const auto& [id, wait] : after) {
    const auto at = before.find(id);
    const double share = at == before.end() ? 0.0 : toSeconds(wait.waited - at->second.waited) / toSeconds(between);
    if (share <= most) continue;
    most = share;
    worst = &wait;
  }
  if (worst == nullptr) return std::nullopt;
  return Finding{Finding::kWarning,
                 "CPU: the computer is overloaded: slamd's thread " + worst->name +
                     number(" waited %.0f %% of the time for the CPU", 100.0 * most) +
                     "; what else is late follows from it",
                 "end other programs (top), or give it a faster computer"};
}

Finding checkClock() {
  if (std::time(nullptr) < kYear2024) {
    return {Finding::kFault, "clock: its year is not true",
            "sudo timedatectl set-ntp true, or set it: sudo date -s ..."};
  }
  timex state{};
  if (adjtimex(&state) == TIME_ERROR || (state.status & STA_UNSYNC) != 0) {
    return {Finding::kWarning, "clock: not synchronised; stamps of other machines will not agree with slamd's",
            "sudo timedatectl set-ntp true"};
  }
  return {Finding::kGood, "clock: synchronised", ""};
}

Findings checkHealth(const health_t& health, const problems_t& problems, Duration ahead) {
  Findings findings;
  const auto add = [&](Finding::Level level, const std::string& what, const problem_t& problem) {
    findings.push_back(
        {level, "slamd, " + what + problem.cause + (problem.meanwhile.empty() ? "" : "; " + problem.meanwhile),
         problem.fix.empty() ? "journalctl -u slamd -n 20 tells since when; slamctl status" : problem.fix});
  };
  for (const device_health_t& device : health.devices) {
    const std::string name = device.name + ": " + nameOf(static_cast<DeviceState>(device.state));
    const bool streams = device.state == static_cast<std::uint8_t>(DeviceState::kStreaming);
    const auto problem = std::find_if(problems.problems.begin(), problems.problems.end(),
                                      [&](const problem_t& p) { return p.device == device.name; });
    if (problem != problems.problems.end()) {
      add(streams ? Finding::kWarning : Finding::kFault, name + ": ", *problem);
    } else if (!streams) {
      findings.push_back({Finding::kFault, "slamd, " + name,
                          "journalctl -u slamd -n 20 tells since when; unplug " + device.name +
                              ", plug it in again, and run slamctl doctor"});
    } else if (device.rate < kRateTolerance * device.expected) {
      findings.push_back(
          {Finding::kWarning,
           "slamd, " + name + number(", %.1f Hz", device.rate) + number(" where %.1f Hz are expected", device.expected),
           "check at which rate it is set to send, its power and its cable; slamctl status in some seconds tells "
           "more"});
    } else {
      findings.push_back({Finding::kGood, "slamd, " + name + number(", %.1f Hz", device.rate), ""});
    }
  }
  for (const problem_t& problem : problems.problems) {
    const bool of_device = std::any_of(health.devices.begin(), health.devices.end(),
                                       [&](const device_health_t& device) { return device.name == problem.device; });
    if (!of_device) add(problem.level > 1 ? Finding::kFault : Finding::kWarning, problem.device + ": ", problem);
  }
  if (ahead > kClockSetBack)
    findings.push_back(
        {Finding::kWarning,
         "slamd: the clock was set back: stamps are " + number("%.1f s ahead of it", toSeconds(ahead)) +
             ", for they never go back",
         "sudo timedatectl set-ntp true; where the clock is right, sudo systemctl restart slamd when the "
         "robot stands"});
  return findings;
}

Finding checkSilence(const Account& slamd, const std::filesystem::path& root) {
  const std::string again = slamd.is_service ? "sudo systemctl restart slamd"
                                             : "sudo kill " + slamd.id + ", -KILL if it stays; start slamd again";
  switch (const char state = processState(slamd.id, root)) {
    case 'T':
    case 't':
      return {Finding::kFault, "slamd: " + slamd.words() + " is stopped, by a signal or a debugger: no pose comes",
              "sudo kill -CONT " + slamd.id};
    case 'Z':
    case '\0':
      return {Finding::kFault, "slamd: " + slamd.words() + " has ended meanwhile",
              "journalctl -u slamd -n 50 tells why it ended"};
    default:
      return {Finding::kFault,
              "slamd: " + slamd.words() + " runs, but sends nothing" +
                  (state == 'D' ? ": it waits for a disk or a device" : ": it hangs"),
              "journalctl -u slamd -n 50 tells what it did last; " + again};
  }
}

}  // namespace slam
