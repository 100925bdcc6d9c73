// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <string>
#include <sys/types.h>

#include "problems/devices.hpp"

namespace slam {

/// What of a device node and of who opens it makes a refusal.
struct NodeRights {
  std::string path;
  std::string group;      ///< that the node belongs to
  bool group_may = true;  ///< the node's mode lets its group read and write
  bool is_member = true;  ///< who opens it is in that group
  bool on_usb = true;     ///< of an adapter on the USB: slamd's udev rules are for these
  std::string tty = {};   ///< the kernel's name, such as ttyAMA0
  gid_t group_id = 0;     ///< number of the group
};
/// As the calling process has them.
NodeRights rightsOf(const std::string& path);

/// Why a port cannot be opened. @param error errno of open()
Problem openProblem(int error, const NodeRights& rights);

}  // namespace slam
