// SPDX-License-Identifier: BSD-3-Clause
#include "tools/slamctl/doctor.hpp"

#include <chrono>
#include <cstdio>
#include <iterator>
#include <utility>

#include "bus/udpm/udpm_url.hpp"
#include "config/service_reach.hpp"
#include "drivers/can/can_socket.hpp"
#include "drivers/imu/iio_device.hpp"
#include "drivers/tcp_port.hpp"
#include "runtime/clock.hpp"
#include "runtime/process_usage.hpp"
#include "tools/slamctl/remote.hpp"

namespace slam {
namespace {

constexpr auto kHealthLimit = std::chrono::seconds(3);  // it comes at 1 Hz

std::filesystem::path workingDirectoryOf(const Account& slamd, const ServiceReach& service) {
  std::error_code error;
  if (slamd.is_service) return service.workingDirectory();
  const auto own =
      slamd.id.empty() ? std::filesystem::path() : std::filesystem::read_symlink("/proc/" + slamd.id + "/cwd", error);
  return own.empty() || error ? std::filesystem::current_path(error) : own;
}

void append(Findings& findings, std::optional<Finding> finding) {
  if (finding) findings.push_back(std::move(*finding));
}
void append(Findings& findings, Findings more) { std::move(more.begin(), more.end(), std::back_inserter(findings)); }

/// Ports that the configuration names, as their owner would open them.
Findings diagnosePorts(const Config& config, const Account& slamd, bool running) {
  struct Used {
    const char *device, *key;
    bool used;
    const std::string& path;
  };
  const Used all[] = {{"lidar", "lidar.port", config.lidar_device.isRead(), config.lidar_device.port},
                      {"base", "base.port", config.base_device.isSerial(), config.base_device.port},
                      {"imu", "imu.port", config.imu_device.isSerial(), config.imu_device.port}};
  Findings findings;
  const auto ports = serialPorts();
  for (const auto& [device, key, used, path] : all) {
    if (!used) continue;
    if (isTcp(path)) {
      // A Hokuyo has one connection: while slamd has it, slamd says how it is.
      if (running) continue;
      findings.push_back(checkTcpLidar(wordOf(config.lidar_device.driver), path));
      continue;
    }
    findings.push_back(checkPort(device, path, key, ports, slamd));
    append(findings, checkClaimants(device, path, key));
  }
  for (const auto& [device, key, used, path] : all) {
    std::error_code none;
    const auto port = std::filesystem::canonical(path, none);
    if (used && !none) append(findings, checkHolders(device, port.string()));
  }
  return findings;
}

Findings diagnoseCan(const Config& config) {
  Findings findings;
  const bool drives = config.base_device.driver == BaseDriver::kCan;
  if (drives || config.imu_device.driver == ImuDriver::kCan) {
    findings.push_back(checkCan(config.can.interface));
    if (drives && findings.back().level != Finding::kFault)
      findings.push_back(checkDrives(config.can, *makeSocketCanPort(monotonicNow)));
  }
  append(findings, checkWatchdog(config.base_device, config.can, *makeSocketCanPort(monotonicNow)));
  return findings;
}

Findings diagnoseCamera(const DepthDeviceConfig& depth, const Account& slamd) {
  if (depth.driver != DepthDriver::kOpenni2) return {};
  Findings findings{checkMounting(depth)};
  if (depth.uri.empty()) findings.push_back(checkCamera(*makeUsbWatch(kPrimeSense), slamd));
  if (!depth.uri.empty() && !depth.uri.ends_with(".oni")) findings.push_back(checkCameraName(depth.uri, listCameras()));
  return findings;
}

Findings diagnoseDisks(const Config& config, const Account& slamd, const ServiceReach& service) {
  Findings findings;
  std::error_code error;
  // A relative path is one of slamd's working directory.
  const std::filesystem::path at = workingDirectoryOf(slamd, service);
  const std::filesystem::path maps =
      at / (config.store.directory.empty() ? "/var/lib/slamd/maps" : config.store.directory);
  if (!config.store.directory.empty() || std::filesystem::is_directory(maps, error))
    findings.push_back(checkDisk("maps", maps, slamd));
  const std::filesystem::path logs = at / (config.log.directory.empty() ? "/var/lib/slamd/log" : config.log.directory);
  if (std::filesystem::is_directory(logs, error)) {
    findings.push_back(checkDisk("logs", logs, slamd));
    if (config.log.automatic) append(findings, checkLogFloor(logs, config.log.floor));
  }
  for (const auto& [what, file] : {std::pair("map files", config.output.map), {"recording", config.output.record}}) {
    if (!file.empty()) findings.push_back(checkDisk(what, (at / file).parent_path(), slamd));
  }
  return findings;
}

/// What slamd itself sends.
/// @param socket empty: over LCM
Findings diagnoseRunning(const Config& config, const std::string& socket, const std::optional<Account>& running,
                         const CpuWaits& waits, Timestamp began) {
  Findings findings;
  Remote remote(socket, config.lcm.url);
  const auto health = remote.health(kHealthLimit);
  if (running) append(findings, checkLoad(waits, cpuWaits(running->id), monotonicNow() - began));
  if (health) {
    // What comes over a network has another computer's clock.
    const bool is_here = !socket.empty() || parseUdpmUrl(config.lcm.url).ttl == 0;
    const Timestamp clock = monotonicNow() + wallClockOffset();
    const Duration ahead = is_here ? fromMicroseconds(health->utime) - clock : Duration(0);
    append(findings, checkHealth(*health, remote.problems(), ahead));
  } else if (running) {
    findings.push_back(checkSilence(*running));
  } else {
    findings.push_back({Finding::kWarning,
                        "slamd: nothing comes from it on " + (socket.empty() ? config.lcm.url : socket),
                        "sudo systemctl start slamd; journalctl -u slamd -n 50 tells why it ended"});
  }
  return findings;
}

}  // namespace

Findings diagnose(const Config& config, const std::string& socket) {
  Findings findings;
  std::error_code error;
  const bool is_installed = std::filesystem::exists(kServiceConfig, error);
  const ServiceReach service;
  const std::optional<Account> running = accountOfSlamd(socket),
                               installed = is_installed ? accountOfUnit(service.account()) : std::nullopt;
  const Account slamd = running ? *running : installed ? *installed : callerAccount();
  const Timestamp began = monotonicNow();
  const CpuWaits waits = running ? cpuWaits(running->id) : CpuWaits{};
  if (is_installed && !running && !installed)
    findings.push_back({Finding::kFault,
                        "service: there is no user " + service.account().user + ", as whom slamd.service runs",
                        "sudo systemd-sysusers, or set User= (sudo systemctl edit slamd)"});
  append(findings, diagnosePorts(config, slamd, running.has_value()));
  if (config.imu_device.driver == ImuDriver::kIio)
    findings.push_back(checkIio(config.imu_device.port, IioDevice::kRoot));
  append(findings, checkSecondSlamd());
  append(findings, checkAdapters());
  append(findings, diagnoseCan(config));
  append(findings, diagnoseCamera(config.depth_device, slamd));
  if (!socket.empty()) findings.push_back(checkSocket(socket));
  const bool local = !socket.empty() && findings.back().level == Finding::kGood;
  const Finding lcm = checkLcm(config.lcm.url);
  findings.push_back(lcm);
  if (config.runtime.realtime) append(findings, checkRealtime(config.runtime.base_priority, slamd));
  append(findings, diagnoseDisks(config, slamd, service));
  for (const auto& problem : is_installed ? service.problemsOf(config) : std::vector<ServiceReach::Problem>{})
    findings.push_back({Finding::kWarning, "service: " + std::string(problem.key) + ": " + problem.what, problem.fix});
  findings.push_back(checkClock());
  findings.push_back(
      {Finding::kGood,
       "not seen from here: who answers on a port (asking would stop a lidar's motor), which firmware it has, how "
       "often "
       "its data come; whether the lidar sees anything, and sits where the configuration has it; whether messages are "
       "refused, and clocks of other computers differ. slamd says these, below or in journalctl -u slamd. Not seen by "
       "anybody: a constant delay of the lidar (slam-replay tells it from a log), watchdogs of ODrives, programs of "
       "other users that have a port open (sudo slamctl doctor)",
       ""});
  if (lcm.level == Finding::kFault && !local) return findings;
  append(findings, diagnoseRunning(config, local ? socket : "", running, waits, began));
  return findings;
}

int print(const Findings& findings) {
  const char* const words[] = {"ok", "warning", "FAULT"};
  int counts[] = {0, 0, 0};
  for (const Finding& finding : findings) {
    ++counts[finding.level];
    std::printf("%-8s %s\n", words[finding.level], finding.what.c_str());
    if (!finding.fix.empty()) std::printf("%-8s   fix: %s\n", "", finding.fix.c_str());
  }
  std::printf("%d faults, %d warnings, %d good\n", counts[Finding::kFault], counts[Finding::kWarning],
              counts[Finding::kGood]);
  return counts[Finding::kFault];
}

}  // namespace slam
