// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/open_words.hpp"

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <grp.h>
#include <mutex>
#include <set>
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

/// Who shall have a port that nobody has given to a group for ports.
std::string noGroupWords(const NodeRights& rights) {
  const std::string begin = "no right to open the port (EACCES): it belongs to group " + rights.group +
                            (rights.group_may ? ", which is no group for ports" : ", which may not read and write it");
  const std::string anew = "sudo udevadm control --reload && sudo udevadm trigger";
  if (rights.on_usb) return begin + "; install slamd's udev rules, then " + anew;
  return begin +
         ", and no rule of slamd's is for a port that is no USB adapter's; end a console on it (sudo systemctl disable "
         "--now serial-getty@" +
         rights.tty + ", and take console=" + rights.tty +
         " out of the kernel's command line), and give it to group dialout: echo 'KERNEL==\"" + rights.tty +
         "\", GROUP=\"dialout\", MODE=\"0660\"' | sudo tee /etc/udev/rules.d/72-" + rights.tty + ".rules, then " + anew;
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

std::string openWords(int error, const NodeRights& rights) {
  switch (error) {
    case ENOENT:
    case ENODEV:
    case ENXIO:
      return "no such port: check cable and udev rule";
    case EBUSY:
      return "the port is in use by another program";
    case EACCES:
      if (rights.group.empty()) return "no right to look at " + rights.path + " (EACCES): check its folder's rights";
      if (!rights.group_may || rights.group == "root") return noGroupWords(rights);
      if (!rights.is_member)
        return "no right to open the port (EACCES): it belongs to group " + rights.group + "; sudo usermod -aG " +
               rights.group + " $USER and log in again, or SupplementaryGroups=" + rights.group + " in the unit";
      return "no right to open the port (EACCES) although group " + rights.group +
             " has it: a security module may forbid it; see dmesg and aa-status";
    case EPERM:
      return "the port may not be opened from here (EPERM): the unit's DevicePolicy or a container's list of devices "
             "leaves it out; DeviceAllow=" +
             rights.path + " rw in the unit (sudo systemctl edit slamd), or docker run --device=" + rights.path;
    case EMFILE:
    case ENFILE:
      return "the port cannot be opened: no file descriptors are left; restart slamd, and raise LimitNOFILE";
    case EIO:
      return "the port cannot be opened (EIO): its adapter does not answer; pull its plug, and plug it in again";
    default:
      return std::string("the port cannot be opened: ") + std::strerror(error) + "; check its path and cable, dmesg";
  }
}

const char* kept(const std::string& words) {
  static std::mutex mutex;
  static std::set<std::string> all;
  const std::scoped_lock lock(mutex);
  return all.insert(words).first->c_str();
}

}  // namespace slam
