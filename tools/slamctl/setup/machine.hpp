// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <filesystem>
#include <iosfwd>
#include <string>
#include <vector>

#include "drivers/search/port_search.hpp"
#include "drivers/serial_port.hpp"

namespace slam {

struct FoundPort {
  std::string path;              ///< that stays with the device, or with its USB socket
  std::string description = {};  ///< of a USB adapter
  PortFinding finding = {};
};

struct FoundBus {
  std::string interface;
  std::vector<int> nodes = {};  ///< whose ODrives send heartbeats
  std::vector<int> vescs = {};  ///< ids of VESCs that send their status
};

/// What is plugged into this computer.
struct Machine {
  std::vector<FoundPort> ports;
  std::vector<FoundBus> buses = {};     ///< CAN interfaces that are up
  std::vector<std::string> chips = {};  ///< IMUs that the kernel reads (IIO), by name
  bool camera = false;                  ///< one that OpenNI2 knows
};

/// The name of a port that does not depend on what else is plugged in: by its adapter's serial number, or by its USB
/// socket where two adapters may have one number. @param root of the file system, for a test
std::string lastingName(const std::string& port, const std::filesystem::path& root = "/");
/// Whether two names lead to one device.
bool isSamePort(const std::string& one, const std::string& other);

/// Looks at each port, all at the same time, some 25 s at most: PortSearch has what is sent. CAN buses are only
/// listened to. @param named ports that the system does not list @param only no other port is looked at @param out gets
/// a line for each
Machine surveyMachine(const std::vector<std::string>& named, bool only, std::ostream& out,
                      const PortOpener& open = openPort);

}  // namespace slam
