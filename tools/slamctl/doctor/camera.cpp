// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cstdint>
#include <cstdio>
#include <fstream>
#include <unistd.h>

#include "tools/slamctl/doctor.hpp"

namespace slam {
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

}  // namespace slam
