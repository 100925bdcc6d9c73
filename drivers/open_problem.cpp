// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/open_problem.hpp"

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <grp.h>
#include <sys/stat.h>
#include <sys/sysmacros.h>
#include <unistd.h>
#include <vector>

#include "drivers/serial_port.hpp"

namespace slam {
namespace {

bool isMemberOf(gid_t group) {
  if (group == getegid()) return true;
  std::vector<gid_t> groups(static_cast<std::size_t>(std::max(0, getgroups(0, nullptr))));
  const int count = getgroups(static_cast<int>(groups.size()), groups.data());
  return count > 0 && std::find(groups.begin(), groups.begin() + count, group) != groups.begin() + count;
}

/// Majors of usbserial (ttyUSB) and cdc-acm (ttyACM), which Linux has fixed.
bool isUsbSerial(dev_t device) { return major(device) == 188 || major(device) == 166; }

/// Of a port that nobody has given to a group for ports.
Problem groupProblem(const NodeRights& rights) {
  const ProblemKind& on_usb = rights.group_may ? problem::kPortOfNoGroup : problem::kPortShut;
  const ProblemKind& on_board = rights.group_may ? problem::kUartOfNoGroup : problem::kUartShut;
  return {rights.on_usb ? on_usb : on_board, {}, {rights.group, rights.tty}};
}

}  // namespace

NodeRights rightsOf(const std::string& path) {
  NodeRights rights{.path = path, .group = {}};
  struct stat node {};
  if (stat(path.c_str(), &node) != 0) return rights;
  std::vector<char> room(4096);
  group found{}, *result = nullptr;
  const bool named = getgrgid_r(node.st_gid, &found, room.data(), room.size(), &result) == 0 && result != nullptr;
  rights.group = named ? result->gr_name : std::to_string(node.st_gid);
  rights.group_may = (node.st_mode & (S_IRGRP | S_IWGRP)) == (S_IRGRP | S_IWGRP);
  rights.is_member = isMemberOf(node.st_gid);
  rights.on_usb = isUsbSerial(node.st_rdev);
  std::error_code error;
  rights.tty = ttyNameOf(path);
  if (rights.tty.empty()) rights.tty = std::filesystem::canonical(path, error).filename();
  rights.group_id = node.st_gid;
  return rights;
}

Problem openProblem(int error, const NodeRights& rights) {
  switch (error) {
    case ENOENT:
    case ENODEV:
    case ENXIO:
      return problem::kPortMissing;
    case EBUSY:
      return problem::kPortInUse;
    case EACCES:
      if (rights.group.empty()) return {problem::kPortHidden, {}, {rights.path}};
      if (!rights.group_may || rights.group == "root") return groupProblem(rights);
      return {rights.is_member ? problem::kPortForbidden : problem::kPortOfOthers, {}, {rights.group}};
    case EPERM:
      return {problem::kPortNotListed, {}, {rights.path}};
    case EMFILE:
    case ENFILE:
      return problem::kNoDescriptors;
    case EIO:
      return problem::kAdapterDead;
    default:
      return {problem::kPortNotOpened, {}, {std::strerror(error)}};
  }
}

}  // namespace slam
