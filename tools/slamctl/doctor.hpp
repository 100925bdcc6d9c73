// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <filesystem>
#include <functional>
#include <optional>
#include <slam/health_t.hpp>
#include <slam/problems_t.hpp>
#include <string>
#include <string_view>
#include <vector>

#include "config/config.hpp"
#include "drivers/byte_stream.hpp"
#include "drivers/camera/openni_camera.hpp"
#include "drivers/camera/usb_watch.hpp"
#include "drivers/can/can_port.hpp"
#include "drivers/serial_port.hpp"
#include "runtime/clock.hpp"
#include "tools/slamctl/account.hpp"

namespace slam {

/// What one check found.
struct Finding {
  enum Level : std::uint8_t { kGood, kWarning, kFault } level = kGood;
  std::string what;  ///< begins with what was looked at
  std::string fix;   ///< the command or setting that helps; empty when all is good
};
using Findings = std::vector<Finding>;

/// The port of a serial device: is it there, may slamd open it? It is not opened: that would stop a lidar's motor.
/// @param key of the configuration, for the fix @param others ports of this machine, to choose from
Finding checkPort(const std::string& device, const std::string& path, const std::string& key,
                  const std::vector<SerialPortInfo>& others, const Account& slamd = callerAccount());
/// An IMU that the kernel reads. @param wanted imu.port @param root of sysfs' IIO devices
Finding checkIio(const std::string& wanted, const std::filesystem::path& root);
/// Does another device claim the same name? @return std::nullopt: none does
std::optional<Finding> checkClaimants(const std::string& device, const std::string& path, const std::string& key,
                                      const std::filesystem::path& root = "/");
/// Has another program opened the port? @param port as the kernel names it
std::optional<Finding> checkHolders(const std::string& device, const std::string& port,
                                    const std::filesystem::path& root = "/");
/// Do several slamd run here?
std::optional<Finding> checkSecondSlamd(const std::filesystem::path& root = "/");
/// USB-serial adapters without a port: their kernel driver is missing, or a program has taken them from it.
Findings checkAdapters(const std::filesystem::path& root = "/");
/// @param root of /sys and /dev
Finding checkCamera(UsbWatch& usb, const Account& slamd = callerAccount(), const std::filesystem::path& root = "/");
/// Is a camera that the configuration names among those that there are?
Finding checkCameraName(const std::string& uri, const std::vector<CameraInfo>& cameras);
/// Is it known where the camera sits?
Finding checkMounting(const DepthDeviceConfig& depth);
/// What is at the address of a lidar on the network: nothing answers, it refuses, it is silent, it is another make.
/// Asks who it is, which starts nothing. @param driver that is configured @param open, now for a test
Finding checkTcpLidar(const std::string& driver, const std::string& path, const PortOpener& open = openPort,
                      Timestamp (*now)() = monotonicNow);
/// @param net the system's list of network interfaces (/sys/class/net)
Finding checkCan(const std::string& interface, const std::filesystem::path& net = "/sys/class/net");
/// Hands on the frames that an open interface receives within a time.
void receiveFor(Duration time, CanPort& port, const std::function<void(const StampedCanFrame&)>& take);
/// The nodes whose ODrives send heartbeats on a CAN interface. Nothing is sent.
struct FoundDrives {
  int error = 0;           ///< errno: it cannot be listened to
  std::vector<int> nodes;  ///< in their order
};
/// @param first nodes that are looked for besides the usual ones
FoundDrives listenForDrives(const std::string& interface, std::vector<int> first, CanPort& port, Duration patience);
/// The ids of the VESCs that send STATUS on a CAN interface, in their order; none where it cannot be listened to.
/// Nothing is sent. @param patience for each 32 of the ids, of which a socket filters no more
std::vector<int> listenForVescs(const std::string& interface, CanPort& port, Duration patience);
/// Listens for the heartbeats of drives. @param port of the interface; nothing is sent
Finding checkDrives(const CanConfig& can, CanPort& port, Duration patience = std::chrono::milliseconds(500));
/// What stops the wheels when slamd cannot. @param port of the interface, if the wheels are on CAN
/// @return std::nullopt: slamd sends no speeds
std::optional<Finding> checkWatchdog(const BaseDeviceConfig& base, const CanConfig& can, CanPort& port);
/// May this user command slamd over its local socket?
Finding checkSocket(const std::string& path);
/// Sends itself a message.
Finding checkLcm(const std::string& url);
/// What slamd's threads have, where it runs; what its service's limits let them have; or what this user's do, tried in
/// a thread of this program. @param priority the highest of the threads' @param root of /proc
Findings checkRealtime(int priority, const Account& slamd, const std::filesystem::path& root = "/");
/// Is there room, and may slamd write there? @param what it holds
Finding checkDisk(const std::string& what, const std::filesystem::path& directory,
                  const Account& slamd = callerAccount());
/// Why a slamd that runs does not answer. @param root of /proc
Finding checkSilence(const Account& slamd, const std::filesystem::path& root = "/");
/// Does the field log stop for lack of room? @return std::nullopt: it does not
std::optional<Finding> checkLogFloor(const std::filesystem::path& directory, double floor);
/// Does slamd get the CPU that it asks for? @param before, after looks at it, with so much time between them
std::optional<Finding> checkLoad(const CpuWaits& before, const CpuWaits& after, Duration between);
Finding checkClock();
/// What a running slamd says of itself: states and rates of its devices, what its pose waits for, and what is not
/// stored. The first findings are the devices', one for each. @param ahead by which its stamps are of this computer's
/// clock
Findings checkHealth(const health_t& health, const problems_t& problems, Duration ahead = Duration(0));

/// All that the configuration asks for. @param socket of slamd; empty: none
Findings diagnose(const Config& config, const std::string& socket);

/// A line for each, with its fix below. @return the number of faults
int print(const Findings& findings);

}  // namespace slam
