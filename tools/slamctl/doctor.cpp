// SPDX-License-Identifier: BSD-3-Clause
#include "tools/slamctl/doctor.hpp"

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <cstdio>
#include <cstring>
#include <ctime>
#include <fstream>
#include <grp.h>
#include <net/if.h>
#include <poll.h>
#include <pwd.h>
#include <sys/resource.h>
#include <sys/timex.h>
#include <thread>
#include <unistd.h>

#include "bus/lcm_link.hpp"
#include "bus/local_client.hpp"
#include "drivers/camera/openni_camera.hpp"
#include "runtime/clock.hpp"
#include "runtime/process_usage.hpp"
#include "runtime/realtime.hpp"
#include "tools/slamctl/remote.hpp"

namespace slam {
namespace {

using namespace std::chrono_literals;
constexpr double kLittleRoom = 200.0;   // [MB] for maps, and the log of a drive
constexpr double kRateTolerance = 0.7;  // [1] of the expected rate
constexpr std::time_t kYear2024 = 1704067200;
constexpr auto kHealthLimit = 3s;  // it comes at 1 Hz
constexpr Duration kEchoLimit = 3s;
constexpr int kEchoPeriod = 100;  // [ms]
constexpr auto kRouteUnits = {"/usr/lib/systemd/system/slamd-multicast.service",
                              "/usr/local/lib/systemd/system/slamd-multicast.service"};

std::string number(const char* format, double value) {
  char text[64];
  std::snprintf(text, sizeof text, format, value);
  return text;
}

std::string listed(const std::vector<SerialPortInfo>& ports) {
  if (ports.empty()) return "this machine has no serial port";
  std::string text = "there are";
  for (const SerialPortInfo& port : ports) {
    text += " " + port.path + " (" + (port.description.empty() ? "no description" : port.description) + ")";
  }
  return text;
}

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

Finding checkPort(const std::string& device, const std::string& path, const std::string& key,
                  const std::vector<SerialPortInfo>& others) {
  std::error_code error;
  if (!std::filesystem::exists(path, error)) {
    return {Finding::kFault, device + ": no port " + path,
            "plug it in; " + listed(others) + "; set " + key +
                ", or install the udev rules: sudo udevadm control --reload"
                " && sudo udevadm trigger"};
  }
  const auto target = std::filesystem::canonical(path, error).string();
  const std::string name = target == path || target.empty() ? path : path + " -> " + target;
  if (access(path.c_str(), R_OK | W_OK) != 0) {
    return {Finding::kFault, device + ": no right to open " + name,
            "sudo usermod -aG dialout $USER, and log in again; the service has the right by its unit"};
  }
  return {Finding::kGood, device + ": " + name, ""};
}

Finding checkCamera(UsbWatch& usb) {
  if (!usb.present()) {
    return {Finding::kFault, "depth: no PrimeSense camera on the USB",
            "plug it into a USB 2 port or a powered hub; lsusb -d 1d27: must list it; or set depth.driver = \"none\""};
  }
  if (!usb.permitted()) {
    return {
        Finding::kFault, "depth: no right to open the camera",
        "sudo apt install libopenni2-0, sudo udevadm control --reload && sudo udevadm trigger, and plug it in again"};
  }
  return {Finding::kGood, "depth: a PrimeSense camera is on the USB", ""};
}

Finding checkMounting(const DepthDeviceConfig& depth) {
  if (depth.isMounted()) return {Finding::kGood, "depth: the camera's height is known", ""};
  return {Finding::kFault, "depth: the camera's height above the floor is not known, its images are not used",
          "measure it, and set depth.z [m]"};
}

Finding checkCan(const std::string& interface, const std::filesystem::path& net) {
  const std::string up = "sudo ip link set " + interface + " up type can bitrate 500000 restart-ms 100";
  std::error_code error;
  if (!std::filesystem::exists(net / interface, error)) {
    return {Finding::kFault, "CAN: no interface " + interface,
            "plug the adapter in, then " + up + "; or set can.interface"};
  }
  unsigned flags = 0;
  std::ifstream(net / interface / "flags") >> std::hex >> flags;
  if ((flags & IFF_UP) == 0) return {Finding::kFault, "CAN: " + interface + " is down", up};
  int queue = 0;
  std::ifstream(net / interface / "tx_queue_len") >> queue;
  if (queue > 0 && queue < 128) {
    return {Finding::kWarning, "CAN: " + interface + " queues only " + std::to_string(queue) + " frames",
            "sudo ip link set " + interface + " txqueuelen 256"};
  }
  return {Finding::kGood, "CAN: " + interface + " is up", ""};
}

std::optional<Finding> checkWatchdog(const BaseDeviceConfig& base) {
  if (!base.speed_commands) return std::nullopt;
  if (base.driver == "handsfree") {
    return Finding{Finding::kGood,
                   "drives: the board's own watchdog stops the motors 0.7 s after the last command; it is always on",
                   ""};
  }
  if (base.driver != "can") return std::nullopt;
  // CANSimple has no message that asks for it.
  return Finding{
      Finding::kWarning,
      "drives: whether the ODrives' own watchdogs are on cannot be seen over CAN; they are off as delivered. "
      "slamd feeds them at 50 Hz, with zeros while nobody drives, and stops the wheels when it can reach them again; "
      "without a watchdog they turn on at the last speed while slamd, the computer or the cable fails",
      "in odrivetool, once: for both axes <axis>.config.watchdog_timeout = 0.5 and "
      "<axis>.config.enable_watchdog = True, then <odrive>.save_configuration()"};
}

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
  const LinkState state = isFault(seen) ? seen : LinkState::kUnheard;
  std::string fix = fixOf(state, link.url());
  const bool has_unit = std::any_of(kRouteUnits.begin(), kRouteUnits.end(), [](const char* unit) {
    std::error_code ignored;
    return std::filesystem::exists(unit, ignored);
  });
  if (state == LinkState::kNoRoute && link.url().ttl == 0 && has_unit)
    fix = "sudo systemctl restart slamd-multicast, or " + fix;
  return {Finding::kFault, "LCM: " + causeOf(state, link.url()) + " (" + url + ")", fix};
}

Findings checkRealtime(int priority) {
  std::string fifo;
  std::thread([&] { fifo = setFifoPriority(priority); }).join();
  Findings findings;
  if (fifo.empty()) {
    findings.push_back({Finding::kGood, "real time: SCHED_FIFO is permitted", ""});
  } else {
    findings.push_back({Finding::kWarning, "real time: this user may not use SCHED_FIFO",
                        "run slamd as a service, or: echo \"$USER - rtprio 95\" | sudo tee -a "
                        "/etc/security/limits.d/slamd.conf, and log in again"});
  }
  rlimit limit{};
  getrlimit(RLIMIT_MEMLOCK, &limit);
  constexpr rlim_t kEnough = 512U << 20;  // [bytes]
  if (geteuid() == 0 || limit.rlim_cur >= kEnough) {
    findings.push_back({Finding::kGood, "real time: memory may be locked", ""});
  } else {
    findings.push_back({Finding::kWarning, "real time: this user may not lock its memory",
                        "run slamd as a service, or: echo \"$USER - memlock unlimited\" | sudo tee -a "
                        "/etc/security/limits.d/slamd.conf, and log in again"});
  }
  return findings;
}

Finding checkDisk(const std::string& what, const std::filesystem::path& directory) {
  std::error_code error;
  const std::string name = "disk: " + what + " in " + directory.string();
  if (!std::filesystem::is_directory(directory, error)) {
    if (error == std::errc::permission_denied) {
      return {Finding::kWarning, name + ": no right to look there", "sudo slamctl doctor"};
    }
    return {Finding::kFault, name + ": there is no such folder", "mkdir -p " + directory.string()};
  }
  if (access(directory.c_str(), W_OK | X_OK) != 0) {
    return {Finding::kFault, name + ": no right to write there", "sudo chown $USER " + directory.string()};
  }
  const double free = diskFreeMegabytes((directory / "map").string());
  if (free >= 0.0 && free < kLittleRoom) {
    return {Finding::kWarning, name + number(": only %.0f MB are free", free),
            "make room: du -sh " + directory.string() + "/*"};
  }
  return {Finding::kGood, name + number(", %.0f MB free", free), ""};
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

Findings checkHealth(const health_t& health) {
  Findings findings;
  for (const device_health_t& device : health.devices) {
    const std::string name = "slamd, " + device.name + ": " + nameOf(static_cast<DeviceState>(device.state));
    if (device.state != static_cast<std::uint8_t>(DeviceState::kStreaming)) {
      findings.push_back({Finding::kFault, name + (device.reason.empty() ? "" : ": " + device.reason),
                          "journalctl -u slamd -n 20 tells since when; unplug " + device.name +
                              ", plug it in again, and run slamctl doctor"});
    } else if (!device.reason.empty() || device.rate < kRateTolerance * device.expected) {
      findings.push_back(
          {Finding::kWarning,
           name + number(", %.1f Hz", device.rate) + number(" where %.1f Hz are expected", device.expected),
           "check the CPU's load (top), and the device's cable"});
    } else {
      findings.push_back({Finding::kGood, name + number(", %.1f Hz", device.rate), ""});
    }
  }
  return findings;
}

Findings diagnose(const Config& config, const std::string& socket) {
  Findings findings;
  const auto ports = serialPorts();
  if (config.lidar_device.driver == "rplidar") {
    findings.push_back(checkPort("lidar", config.lidar_device.port, "lidar.port", ports));
  }
  if (config.base_device.driver == "handsfree") {
    findings.push_back(checkPort("base", config.base_device.port, "base.port", ports));
  }
  if (config.imu_device.driver == "hfi") {
    findings.push_back(checkPort("imu", config.imu_device.port, "imu.port", ports));
  }
  if (config.base_device.driver == "can" || config.imu_device.driver == "can") {
    findings.push_back(checkCan(config.can.interface));
  }
  if (auto watchdog = checkWatchdog(config.base_device)) findings.push_back(std::move(*watchdog));
  if (config.depth_device.driver == "openni2") findings.push_back(checkMounting(config.depth_device));
  if (config.depth_device.driver == "openni2" && config.depth_device.uri.empty()) {
    const auto usb = makeUsbWatch(kPrimeSense);
    findings.push_back(checkCamera(*usb));
  }
  if (!socket.empty()) findings.push_back(checkSocket(socket));
  const bool local = !socket.empty() && findings.back().level == Finding::kGood;
  const Finding lcm = checkLcm(config.lcm.url);
  findings.push_back(lcm);
  if (config.runtime.realtime) {
    for (Finding& finding : checkRealtime(config.runtime.base_priority)) findings.push_back(std::move(finding));
  }
  const std::filesystem::path maps = config.store.directory.empty() ? "/var/lib/slamd/maps" : config.store.directory;
  std::error_code error;
  if (!config.store.directory.empty() || std::filesystem::is_directory(maps, error)) {
    findings.push_back(checkDisk("maps", maps));
  }
  const std::filesystem::path logs = config.log.directory.empty() ? "/var/lib/slamd/log" : config.log.directory;
  if (std::filesystem::is_directory(logs, error)) findings.push_back(checkDisk("logs", logs));
  for (const auto& [what, file] : {std::pair("map files", config.output.map), {"recording", config.output.record}}) {
    if (file.empty()) continue;
    const auto folder = std::filesystem::path(file).parent_path();
    findings.push_back(checkDisk(what, folder.empty() ? "." : folder));
  }
  findings.push_back(checkClock());
  if (lcm.level == Finding::kFault && !local) return findings;
  Remote remote(local ? socket : "", config.lcm.url);
  if (const auto health = remote.health(kHealthLimit)) {
    for (Finding& finding : checkHealth(*health)) findings.push_back(std::move(finding));
  } else {
    findings.push_back({Finding::kWarning, "slamd: it is not heard on " + (local ? socket : config.lcm.url),
                        "sudo systemctl start slamd; journalctl -u slamd -n 50 tells why it ended"});
  }
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
