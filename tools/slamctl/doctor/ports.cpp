// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cerrno>
#include <fstream>
#include <iterator>
#include <unistd.h>

#include "drivers/imu/iio_device.hpp"
#include "drivers/open_problem.hpp"
#include "drivers/search/port_holder.hpp"
#include "drivers/udev_links.hpp"
#include "tools/slamctl/doctor.hpp"

namespace slam {
namespace {

std::string listed(const std::vector<SerialPortInfo>& ports) {
  if (ports.empty()) return "this machine has no serial port";
  std::string text = "there are";
  for (const SerialPortInfo& port : ports) {
    text += " " + port.path + " (" + (port.description.empty() ? "no description" : port.description) + ")";
  }
  return text;
}

/// How who runs slamd is given a group.
std::string groupFix(const std::string& group, const Account& slamd) {
  const bool is_caller = slamd.source == Account::kCaller;
  return "sudo usermod -aG " + group + " " + (is_caller ? "$USER" : slamd.userName()) +
         (slamd.is_service ? " && sudo systemctl restart slamd"
          : is_caller      ? ", and log in again; the service has the right by its unit"
                           : ", log in again, and start slamd again");
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
  const auto holder = holderOf(port, root, "slamd");
  if (!holder) return std::nullopt;
  const auto& [id, name, folder] = *holder;
  std::string fix = "sudo kill " + id;
  if (name == "ModemManager") fix = "sudo systemctl disable --now ModemManager, or install slamd's udev rules";
  if (name == "brltty") fix = "sudo apt remove brltty, or install slamd's udev rules";
  if (name == "agetty")
    fix = "sudo systemctl disable --now serial-getty@" + std::filesystem::path(port).filename().string();
  return Finding{Finding::kFault,
                 device + ": " + name + " (" + id + ") has " + port + " open: it takes bytes that slamd misses", fix};
}

std::optional<Finding> checkSecondSlamd(const std::filesystem::path& root) {
  std::string ids;
  int count = 0;
  for (const RunningProgram& program : runningPrograms(root)) {
    if (program.name != "slamd") continue;
    ids += " " + program.id;
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

Finding checkIio(const std::string& wanted, const std::filesystem::path& root) {
  Problem problem;
  const auto device = IioDevice::find(wanted, problem, root);
  if (!device) return {Finding::kFault, "imu: " + problem.cause(), problem.fix()};
  return {Finding::kGood, "imu: " + device->name() + ", which the kernel reads", ""};
}

}  // namespace slam
