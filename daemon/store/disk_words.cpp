// SPDX-License-Identifier: BSD-3-Clause
#include "store/disk_words.hpp"

#include <cerrno>
#include <cmath>
#include <system_error>

#include "store/durable_file.hpp"
#include "store/map_codec.hpp"

namespace slam {
namespace {

namespace fs = std::filesystem;

int codeOf(const std::exception& error) {
  if (const auto* disk = dynamic_cast<const DiskError*>(&error)) return disk->code;
  if (const auto* system = dynamic_cast<const std::system_error*>(&error)) return system->code().value();
  return 0;
}

/// Of the disk that a folder lies on, or would lie on.
std::string freeOn(fs::path folder) {
  std::error_code error;
  while (!folder.empty() && folder != folder.parent_path() && !fs::exists(folder, error)) folder = folder.parent_path();
  const auto space = fs::space(folder, error);
  return error ? "" : " (" + std::to_string(std::llround(static_cast<double>(space.available) / 1e6)) + " MB free)";
}

}  // namespace

DiskWords diskWords(const std::exception& error, const fs::path& folder) {
  const std::string name = folder.string(), what = error.what();
  if (dynamic_cast<const ImplausibleMap*>(&error) != nullptr)
    return {"the map " + what, "slamctl reset begins a new map; what is stored stays"};
  switch (codeOf(error)) {
    case ENOSPC:
      return {"no space on " + name + freeOn(folder), "make room: sudo du -sh " + name + "/*; slamctl log list"};
    case EDQUOT:
      return {"the disk quota of " + name + " is used up" + freeOn(folder), "make room: sudo du -sh " + name + "/*"};
    case EROFS:
      return {name + " is read-only",
              "sudo dmesg | tail says whether the kernel has found errors on the disk; replace it, or sudo mount -o "
              "remount,rw its mount point"};
    case EIO:
    case ENODEV:
    case ENXIO:
      return {"the disk of " + name + " reports errors: " + what,
              "sudo dmesg | tail says which; check its plug, replace it"};
    case EACCES:
    case EPERM:
      return {what, "make the folder writable for slamd: sudo chown -R slamd: " + name};
    case EISDIR:
    case EEXIST:
    case ENOTEMPTY:
    case ELOOP:
      return {what, "something else lies in its place: move it out of " + name};
    case ENOENT:
    case ENOTDIR:
    case ESTALE:
      return {what + ": has its disk gone?", "plug the disk in and mount it again, or make the folder " + name};
    default:
      return {what, "make room, or its folder writable"};
  }
}

}  // namespace slam
