// SPDX-License-Identifier: BSD-3-Clause
#include "tools/slamctl/setup/machine.hpp"

#include <algorithm>
#include <fstream>
#include <future>
#include <net/if.h>
#include <ostream>

#include "drivers/camera/usb_watch.hpp"
#include "drivers/can/can_socket.hpp"
#include "drivers/imu/iio_device.hpp"
#include "drivers/search/port_holder.hpp"
#include "drivers/tcp_port.hpp"
#include "drivers/udev_links.hpp"
#include "firmware_if/can_odrive.hpp"
#include "runtime/clock.hpp"
#include "tools/slamctl/doctor.hpp"

namespace slam {
namespace {

namespace fs = std::filesystem;
using namespace std::chrono_literals;

constexpr int kCanInterface = 280;    // ARPHRD_CAN of /sys/class/net/NAME/type
constexpr Duration kStatus = 250ms;   // a VESC sends STATUS at 50 Hz, or at 5 Hz by its slower rate
constexpr Duration kHeartbeats = 1s;  // an ODrive sends one each 100 ms

std::vector<std::string> namesIn(const fs::path& folder) {
  std::vector<std::string> names;
  std::error_code error;
  for (fs::directory_iterator at(folder, error), end; !error && at != end; at.increment(error))
    names.push_back(at->path().filename().string());
  std::sort(names.begin(), names.end());
  return names;
}

std::string linkTo(const fs::path& port, const fs::path& folder) {
  for (const std::string& name : namesIn(folder)) {
    if (isSamePort(folder / name, port)) return folder / name;
  }
  return "";
}

void describe(const FoundPort& port, std::ostream& out) {
  const PortFinding& found = port.finding;
  out << "  " << port.path << (port.description.empty() ? "" : " (" + port.description + ")") << ": ";
  if (found.kind == PortFinding::kNothing) {
    out << found.problem.cause() << "\n";
    if (!found.is_open && !found.problem.fix().empty()) out << "    fix: " << found.problem.fix() << "\n";
    return;
  }
  out << found.name << (found.baud > 0 ? ", at " + std::to_string(found.baud) + " bit/s" : "") << "\n";
}

FoundPort surveyPort(const SerialPortInfo& port, const PortOpener& open) {
  const std::atomic<bool> cancel{false};
  FoundPort found{.path = isTcp(port.path) ? port.path : lastingName(port.path), .description = port.description};
  std::error_code error;
  const fs::path device = fs::canonical(port.path, error);
  // What another program reads is not looked at: it would lose bytes, and a getty or a modem's manager sends.
  if (const auto holder = error ? std::nullopt : holderOf(device.string())) {
    found.finding = {.problem = heldBy(*holder), .is_open = false};
    return found;
  }
  found.finding = PortSearch(port.path, open, &monotonicNow).find(cancel);
  return found;
}

std::vector<FoundBus> surveyBuses() {
  std::vector<FoundBus> buses;
  const fs::path net = "/sys/class/net";
  for (const std::string& name : namesIn(net)) {
    int type = 0;
    unsigned flags = 0;
    std::ifstream(net / name / "type") >> type;
    std::ifstream(net / name / "flags") >> std::hex >> flags;
    if (type != kCanInterface || (flags & IFF_UP) == 0) continue;
    const auto port = makeSocketCanPort(monotonicNow);
    buses.push_back({name,
                     listenForDrives(name, {can::odrive::kLeftNode, can::odrive::kRightNode}, *port, kHeartbeats).nodes,
                     listenForVescs(name, *port, kStatus)});
  }
  return buses;
}

}  // namespace

bool isSamePort(const std::string& one, const std::string& other) {
  if (one == other) return true;
  std::error_code error;
  return fs::equivalent(one, other, error) && !error;
}

std::string lastingName(const std::string& port, const fs::path& root) {
  const std::string by_path = linkTo(port, root / "dev/serial/by-path"),
                    by_id = linkTo(port, root / "dev/serial/by-id");
  // Cheap adapters all have the number 0001, so that the next one that is plugged in takes the name over.
  const bool own_number = !by_id.empty() && by_id.find("_0001-") == std::string::npos && claimantsOf(by_id).size() < 2;
  return own_number ? by_id : by_path.empty() ? port : by_path;
}

Machine surveyMachine(const std::vector<std::string>& named, bool only, std::ostream& out, const PortOpener& open) {
  std::vector<SerialPortInfo> ports = only ? std::vector<SerialPortInfo>{} : serialPorts();
  for (const std::string& path : named) {
    const bool listed =
        std::any_of(ports.begin(), ports.end(), [&](const auto& port) { return isSamePort(port.path, path); });
    if (!listed) ports.push_back({path, ""});
  }
  out << "Looking at " << ports.size() << (ports.size() == 1 ? " port" : " ports")
      << "; a lidar's motor may start or stop, nothing else moves.\n"
      << std::flush;
  std::vector<std::future<FoundPort>> searches;
  for (const SerialPortInfo& port : ports)
    searches.push_back(std::async(std::launch::async, [&port, &open] { return surveyPort(port, open); }));
  Machine machine{.ports = {}, .buses = surveyBuses()};
  for (auto& search : searches) describe(machine.ports.emplace_back(search.get()), out);
  for (const FoundBus& bus : machine.buses) {
    out << "  " << bus.interface << ": "
        << (!bus.nodes.empty()   ? "ODrives with the nodes"
            : !bus.vescs.empty() ? "VESCs with the ids"
                                 : "no ODrive sends heartbeats, no VESC its status");
    for (const int node : bus.nodes.empty() ? bus.vescs : bus.nodes) out << " " << node;
    out << "\n";
  }
  for (const std::string& name : namesIn(IioDevice::kRoot)) {
    Problem none;
    const auto chip = IioDevice::find((fs::path(IioDevice::kRoot) / name).string(), none);
    if (chip) machine.chips.push_back(chip->name());
    if (chip) out << "  " << chip->name() << ": an IMU that the kernel reads\n";
  }
  machine.camera = makeUsbWatch(kPrimeSense)->present();
  if (machine.camera) out << "  USB: a depth camera that OpenNI2 knows\n";
  return machine;
}

}  // namespace slam
