// SPDX-License-Identifier: BSD-3-Clause
#include "store/disk_problem.hpp"

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

Problem diskProblem(const std::exception& error, const fs::path& folder) {
  const std::string name = folder.string();
  const auto of = [&](const ProblemKind& kind, const std::string& detail) {
    return Problem(kind, {}, {name, "", detail});
  };
  if (dynamic_cast<const ImplausibleMap*>(&error) != nullptr) return of(problem::kMapImplausible, error.what());
  switch (codeOf(error)) {
    case ENOSPC:
      return of(problem::kDiskFull, freeOn(name));
    case EDQUOT:
      return of(problem::kDiskQuota, freeOn(name));
    case EROFS:
      return of(problem::kDiskReadOnly, "");
    case EIO:
    case ENODEV:
    case ENXIO:
      return of(problem::kDiskErrors, error.what());
    case EACCES:
    case EPERM:
      return of(problem::kDiskRefuses, error.what());
    case EISDIR:
    case EEXIST:
    case ENOTEMPTY:
    case ELOOP:
      return of(problem::kDiskInTheWay, error.what());
    case ENOENT:
    case ENOTDIR:
    case ESTALE:
      return of(problem::kDiskGone, error.what());
    default:
      return of(problem::kDiskFails, error.what());
  }
}

}  // namespace slam
