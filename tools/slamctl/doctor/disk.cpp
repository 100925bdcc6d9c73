// SPDX-License-Identifier: BSD-3-Clause
#include <sys/statvfs.h>
#include <unistd.h>

#include "drivers/open_problem.hpp"
#include "runtime/process_usage.hpp"
#include "tools/slamctl/doctor.hpp"
#include "tools/slamctl/doctor/number.hpp"

namespace slam {
namespace {

constexpr double kLittleRoom = 200.0;  // [MB] for maps, and the log of a drive

}  // namespace

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

}  // namespace slam
