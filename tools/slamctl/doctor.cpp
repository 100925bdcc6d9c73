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
#include <limits>
#include <map>
#include <net/if.h>
#include <poll.h>
#include <pwd.h>
#include <sstream>
#include <sys/resource.h>
#include <sys/statvfs.h>
#include <sys/timex.h>
#include <thread>
#include <tuple>
#include <unistd.h>

#include "bus/local_client.hpp"
#include "bus/udpm/lcm_link.hpp"
#include "config/service_reach.hpp"
#include "drivers/can/can_axis.hpp"
#include "drivers/can/can_socket.hpp"
#include "drivers/imu/iio_device.hpp"
#include "drivers/open_problem.hpp"
#include "drivers/tcp_port.hpp"
#include "drivers/udev_links.hpp"
#include "runtime/clock.hpp"
#include "runtime/process_usage.hpp"
#include "runtime/realtime.hpp"
#include "tools/slamctl/drive_watchdogs.hpp"
#include "tools/slamctl/remote.hpp"

namespace slam {
namespace {

using namespace std::chrono_literals;
constexpr double kLittleRoom = 200.0;   // [MB] for maps, and the log of a drive
constexpr double kRateTolerance = 0.7;  // [1] of the expected rate
constexpr std::time_t kYear2024 = 1704067200;
constexpr auto kHealthLimit = 3s;          // it comes at 1 Hz
constexpr Duration kClockSetBack = 500ms;  // more than a clock is slewed by
constexpr Duration kEchoLimit = 3s;
constexpr int kEchoPeriod = 100;                     // [ms]
constexpr std::uint64_t kEnoughLocked = 512U << 20;  // [bytes] of memory
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

struct Process {
  std::string id, name;
  std::filesystem::path folder;  // below /proc
};

std::vector<Process> processesIn(const std::filesystem::path& root) {
  std::vector<Process> processes;
  std::error_code error;
  for (std::filesystem::directory_iterator at(root / "proc", error), end; !error && at != end; at.increment(error)) {
    const std::string id = at->path().filename().string();
    if (id.find_first_not_of("0123456789") != std::string::npos) continue;
    Process& process = processes.emplace_back(Process{id, "", at->path()});
    std::ifstream(at->path() / "comm") >> process.name;
  }
  return processes;
}

/// How who runs slamd is given a group.
std::string groupFix(const std::string& group, const Account& slamd) {
  const bool is_caller = slamd.source == Account::kCaller;
  return "sudo usermod -aG " + group + " " + (is_caller ? "$USER" : slamd.userName()) +
         (slamd.is_service ? " && sudo systemctl restart slamd"
          : is_caller      ? ", and log in again; the service has the right by its unit"
                           : ", log in again, and start slamd again");
}

/// How the limits of who runs slamd are raised. @param unit setting of the unit @param shell line of limits.d
std::string limitFix(const Account& slamd, const std::string& unit, const std::string& shell) {
  if (slamd.is_service)
    return "sudo systemctl edit slamd, write " + unit + " into [Service], and sudo systemctl restart slamd";
  const bool is_caller = slamd.source == Account::kCaller;
  return "run slamd as a service, or: echo \"" + (is_caller ? "$USER" : slamd.userName()) + " - " + shell +
         "\" | sudo tee -a /etc/security/limits.d/slamd.conf, and log in again" +
         (is_caller ? "" : "; then start slamd again");
}

std::filesystem::path workingDirectoryOf(const Account& slamd, const ServiceReach& service) {
  std::error_code error;
  if (slamd.is_service) return service.workingDirectory();
  const auto own =
      slamd.id.empty() ? std::filesystem::path() : std::filesystem::read_symlink("/proc/" + slamd.id + "/cwd", error);
  return own.empty() || error ? std::filesystem::current_path(error) : own;
}

constexpr std::uint64_t kUnlimited = std::numeric_limits<std::uint64_t>::max();

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

Finding checkPort(const std::string& device, const std::string& path, const std::string& key,
                  const std::vector<SerialPortInfo>& others, const Account& slamd) {
  std::error_code error;
  if (!std::filesystem::exists(path, error)) {
    return {Finding::kFault, device + ": no port " + path,
            "plug it in; " + listed(others) + "; set " + key +
                ", or install the udev rules: sudo udevadm control --reload"
                " && sudo udevadm trigger"};
  }
  const auto target = std::filesystem::canonical(path, error).string();
  std::string name = target == path || target.empty() ? path : path + " -> " + target;
  const std::string tty = ttyNameOf(path);
  if (!tty.empty() && !target.ends_with("/" + tty)) name += ", which is " + tty;
  if (permissionOf(slamd, path, R_OK | W_OK) == Permission::kRefused) {
    NodeRights rights = rightsOf(path);
    rights.is_member = slamd.has(rights.group_id);
    const Problem problem = openProblem(EACCES, rights);
    const bool by_group = rights.group_may && rights.group != "root" && !rights.is_member;
    return {Finding::kFault,
            device + ": " + slamd.words() + " has no right to open " + name + " of group " + rights.group,
            by_group ? groupFix(rights.group, slamd) : problem.fix()};
  }
  return {Finding::kGood, device + ": " + name, ""};
}

std::optional<Finding> checkClaimants(const std::string& device, const std::string& path, const std::string& key,
                                      const std::filesystem::path& root) {
  const auto claimants = claimantsOf(path, root);
  if (claimants.size() < 2) return std::nullopt;
  std::string fix = "set " + key + " to the name of the USB socket that it is in:";
  for (const Claimant& claimant : claimants) {
    fix += " " + (claimant.by_path.empty() ? "/dev/" + claimant.name : claimant.by_path) +
           (&claimant == &claimants.back() ? "" : " or");
  }
  return Finding{Finding::kFault, device + ": " + describeClaimants(path, claimants), fix};
}

std::optional<Finding> checkHolders(const std::string& device, const std::string& port,
                                    const std::filesystem::path& root) {
  for (const Process& process : processesIn(root)) {
    if (process.name == "slamd") continue;
    std::error_code error;
    for (std::filesystem::directory_iterator at(process.folder / "fd", error), end; !error && at != end;
         at.increment(error)) {
      std::error_code ignored;
      if (std::filesystem::read_symlink(at->path(), ignored) != port) continue;
      std::string fix = "sudo kill " + process.id;
      if (process.name == "ModemManager")
        fix = "sudo systemctl disable --now ModemManager, or install slamd's udev rules";
      if (process.name == "brltty") fix = "sudo apt remove brltty, or install slamd's udev rules";
      if (process.name == "agetty")
        fix = "sudo systemctl disable --now serial-getty@" + std::filesystem::path(port).filename().string();
      return Finding{Finding::kFault,
                     device + ": " + process.name + " (" + process.id + ") has " + port +
                         " open: it takes bytes that slamd misses",
                     fix};
    }
  }
  return std::nullopt;
}

std::optional<Finding> checkSecondSlamd(const std::filesystem::path& root) {
  std::string ids;
  int count = 0;
  for (const Process& process : processesIn(root)) {
    if (process.name != "slamd") continue;
    ids += " " + process.id;
    ++count;
  }
  if (count < 2) return std::nullopt;
  return Finding{Finding::kWarning, "slamd: " + std::to_string(count) + " of them run here:" + ids,
                 "stop all but one (sudo systemctl stop slamd; sudo kill ID), or give each an lcm.url, ports and a "
                 "store.directory of its own"};
}

Findings checkAdapters(const std::filesystem::path& root) {
  struct Kind {
    const char *vendor, *module;
  };
  constexpr Kind kKinds[] = {{"10c4", "cp210x"}, {"0403", "ftdi_sio"}, {"1a86", "ch341"}, {"067b", "pl2303"}};
  Findings findings;
  std::error_code error;
  const auto devices = root / "sys" / "bus" / "usb" / "devices";
  for (std::filesystem::directory_iterator at(devices, error), end; !error && at != end; at.increment(error)) {
    std::string vendor, product;
    std::ifstream(at->path() / "idVendor") >> vendor;
    std::ifstream(at->path() / "idProduct") >> product;
    const auto* kind =
        std::find_if(std::begin(kKinds), std::end(kKinds), [&](const Kind& k) { return k.vendor == vendor; });
    if (kind == std::end(kKinds)) continue;
    const std::string name = at->path().filename().string(),
                      what = "USB: the adapter " + vendor + ":" + product + " at " + name;
    std::error_code ignored;
    for (std::filesystem::directory_iterator part(at->path(), ignored), last; !ignored && part != last;
         part.increment(ignored)) {
      if (!part->path().filename().string().starts_with(name + ":")) continue;
      std::error_code none;
      const auto driver = std::filesystem::canonical(part->path() / "driver", none).filename().string();
      if (none) {
        findings.push_back({Finding::kFault, what + " has no port: no kernel driver has it",
                            std::string("sudo modprobe ") + kind->module + ", and plug it in again"});
      } else if (driver == "usbfs") {
        findings.push_back(
            {Finding::kFault,
             what + " has no port: a program has taken it from its kernel driver; brltty, which takes it for a "
                    "braille display, does so",
             "sudo apt remove brltty, or install slamd's udev rules; then plug it in again"});
      }
    }
  }
  return findings;
}

Finding checkCameraName(const std::string& uri, const std::vector<CameraInfo>& cameras) {
  std::string list;
  for (const CameraInfo& camera : cameras) {
    if (camera.uri == uri) return {Finding::kGood, "depth: the camera " + uri + " is there", ""};
    list += (list.empty() ? "" : ", ") + describe(camera);
  }
  return {Finding::kFault, "depth: there is no camera " + uri,
          (list.empty() ? "plug one in; OpenNI2 finds none" : "there is " + list) +
              "; set depth.uri, or leave it empty for the first one: a camera's name changes with its USB socket"};
}

namespace {

/// Nodes of the devices of one vendor on the USB.
std::vector<std::filesystem::path> usbNodesOf(std::uint16_t vendor, const std::filesystem::path& root) {
  std::vector<std::filesystem::path> nodes;
  std::error_code error;
  for (std::filesystem::directory_iterator at(root / "sys/bus/usb/devices", error), end; !error && at != end;
       at.increment(error)) {
    unsigned id = 0, bus = 0, number = 0;
    std::ifstream(at->path() / "idVendor") >> std::hex >> id;
    std::ifstream(at->path() / "busnum") >> bus;
    if (id != vendor || !(std::ifstream(at->path() / "devnum") >> number)) continue;
    char name[32];
    std::snprintf(name, sizeof name, "dev/bus/usb/%03u/%03u", bus, number);
    nodes.push_back(root / name);
  }
  return nodes;
}

}  // namespace

Finding checkCamera(UsbWatch& usb, const Account& slamd, const std::filesystem::path& root) {
  if (!usb.present()) {
    return {Finding::kFault, "depth: no PrimeSense camera on the USB",
            "plug it into a USB 2 port or a powered hub; lsusb -d 1d27: must list it; or set depth.driver = \"none\""};
  }
  const auto nodes =
      slamd.source == Account::kCaller ? std::vector<std::filesystem::path>{} : usbNodesOf(kPrimeSense.vendor, root);
  const bool permitted =
      nodes.empty() ? usb.permitted() : std::any_of(nodes.begin(), nodes.end(), [&](const auto& node) {
        return permissionOf(slamd, node, R_OK | W_OK) != Permission::kRefused;
      });
  if (!permitted) {
    return {
        Finding::kFault, "depth: " + slamd.words() + " has no right to open the camera",
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

Finding checkDrives(const CanConfig& can, CanPort& port, Duration patience) {
  namespace odrive = can::odrive;
  // Of all nodes there are more ids than a socket filters by: those that people use, and the first ones.
  std::vector<int> nodes{can.left_node, can.right_node};
  for (int node = 0; nodes.size() < 32; ++node) {
    if (std::find(nodes.begin(), nodes.end(), node) == nodes.end()) nodes.push_back(node);
  }
  std::vector<std::uint32_t> ids;
  for (const int node : nodes) ids.push_back(odrive::idOf(node, odrive::Command::kHeartbeat));
  if (const int error = port.open(can.interface, ids); error != 0)
    return {Finding::kWarning, "CAN: it cannot be listened to on " + can.interface + ": " + std::strerror(error),
            "sudo slamctl doctor"};
  std::map<int, CanAxis> heard;
  StampedCanFrame received;
  for (const Timestamp end = monotonicNow() + patience; monotonicNow() < end;) {
    if (port.receive(received) != 0) {
      std::this_thread::sleep_for(5ms);
      continue;
    }
    const int node = static_cast<int>(received.frame.id >> 5);
    if (!received.frame.error) heard[node].addHeartbeat(received.stamp, node, received.frame);
  }
  port.close();
  std::string list;
  for (const auto& [node, axis] : heard) list += (list.empty() ? "" : ", ") + std::to_string(node);
  const bool both = heard.contains(can.left_node) && heard.contains(can.right_node);
  if (both) return {Finding::kGood, "CAN: the drives of both wheels send heartbeats", ""};
  const std::string missing = !heard.contains(can.left_node)
                                  ? "left wheel (can.left_node = " + std::to_string(can.left_node) + ")"
                                  : "right wheel (can.right_node = " + std::to_string(can.right_node) + ")";
  return {Finding::kFault, "CAN: no heartbeat of the " + missing,
          list.empty() ? "switch the drives on, check the bit rate: ip -details link show " + can.interface
                       : "nodes that send heartbeats: " + list + "; set can.left_node and can.right_node"};
}

std::optional<Finding> checkWatchdog(const BaseDeviceConfig& base, const CanConfig& can, CanPort& port) {
  if (!base.speed_commands) return std::nullopt;
  if (base.driver == BaseDriver::kHandsfree) {
    return Finding{Finding::kGood,
                   "drives: the board's own watchdog stops the motors 0.7 s after the last command; it is always on",
                   ""};
  }
  if (base.driver == BaseDriver::kRosArduinoBridge || base.driver == BaseDriver::kKobuki) {
    const bool arduino = base.driver == BaseDriver::kRosArduinoBridge;
    return Finding{Finding::kGood,
                   std::string("drives: the base's own watchdog stops the motors ") + (arduino ? "2 s" : "0.6 s") +
                       " after the last command; it is always on",
                   ""};
  }
  if (base.driver == BaseDriver::kCreate2) {
    return Finding{
        Finding::kWarning,
        "drives: a Create or Roomba has no watchdog: it keeps its last speed while slamd, the computer or the "
        "cable is down, until it meets an edge",
        "keep its CLEAN button within reach: pressed, it stops the robot"};
  }
  if (base.driver != BaseDriver::kCan) return std::nullopt;
  return checkDriveWatchdogs(can, port);
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
  const LinkState state = isFault(seen) ? seen : LinkState::kUnheard;
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

Finding checkDisk(const std::string& what, const std::filesystem::path& directory, const Account& slamd) {
  std::error_code error;
  const std::string name = "disk: " + what + " in " + directory.string();
  const bool is_caller = slamd.source == Account::kCaller;
  const std::string owner = slamd.userName() + ":" + slamd.groupName();
  if (!std::filesystem::is_directory(directory, error)) {
    if (error == std::errc::permission_denied) {
      return {Finding::kWarning, name + ": no right to look there", "sudo slamctl doctor"};
    }
    return {Finding::kFault, name + ": there is no such folder",
            is_caller ? "mkdir -p " + directory.string()
                      : "sudo install -d -o " + slamd.userName() + " -g " + slamd.groupName() + " -m 750 " +
                            directory.string()};
  }
  struct statvfs disk {};
  if (statvfs(directory.c_str(), &disk) == 0 && (disk.f_flag & ST_RDONLY) != 0)
    return {
        Finding::kFault, name + ": the disk is read-only",
        "sudo dmesg | tail says whether the kernel has found errors on it; replace it, or sudo mount -o remount,rw " +
            directory.string()};
  switch (permissionOf(slamd, directory, W_OK | X_OK)) {
    case Permission::kRefused:
      return {Finding::kFault, name + ": " + slamd.words() + " has no right to write there",
              is_caller ? "sudo chown $USER " + directory.string() + ", if slamd is to run as this user"
                        : "sudo chown -R " + owner + " " + directory.string()};
    case Permission::kUnseen:
      return {Finding::kWarning, name + ": whether " + slamd.words() + " may write there is not seen by this user",
              "sudo slamctl doctor"};
    default:
      break;
  }
  if (disk.f_files > 0 && disk.f_favail == 0)
    return {Finding::kFault, name + ": the disk has no room for another file (no inode is free)",
            "remove small files: sudo du --inodes -d 2 " + directory.string()};
  const double free = diskFreeMegabytes((directory / "map").string());
  if (free >= 0.0 && free < kLittleRoom) {
    return {Finding::kWarning, name + number(": only %.0f MB are free", free),
            "make room: du -sh " + directory.string() + "/*"};
  }
  return {Finding::kGood, name + number(", %.0f MB free", free), ""};
}

std::optional<Finding> checkLogFloor(const std::filesystem::path& directory, double floor) {
  const double free = diskFreeMegabytes((directory / "run").string());
  if (free < 0.0 || free >= floor) return std::nullopt;
  return Finding{Finding::kWarning,
                 "disk: the field log stops: " + number("%.0f MB are free", free) +
                     number(" where log.floor keeps %.0f MB for the maps", floor),
                 "make room: slamctl log list; or set log.floor"};
}

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

Finding checkIio(const std::string& wanted, const std::filesystem::path& root) {
  Problem problem;
  const auto device = IioDevice::find(wanted, problem, root);
  if (!device) return {Finding::kFault, "imu: " + problem.cause(), problem.fix()};
  return {Finding::kGood, "imu: " + device->name() + ", which the kernel reads", ""};
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

namespace {

void append(Findings& findings, std::optional<Finding> finding) {
  if (finding) findings.push_back(std::move(*finding));
}
void append(Findings& findings, Findings more) { std::move(more.begin(), more.end(), std::back_inserter(findings)); }

/// Ports that the configuration names, as their owner would open them.
Findings diagnosePorts(const Config& config, const Account& slamd) {
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
    if (!used || isTcp(path)) continue;
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
  append(findings, diagnosePorts(config, slamd));
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
