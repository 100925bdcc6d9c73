// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "core/timestamp.hpp"
#include "store/log_folder.hpp"

/// How field logs share a disk with the maps. Pure.
namespace slam {

struct LogLimits {
  std::uint64_t quota = 0;  ///< [bytes] of all logs together
  std::uint64_t floor = 0;  ///< [bytes] that stay free on the disk
  Duration file_length{0};

  /// [bytes] A file ends here, too: the open one, one that is being compressed and the closed ones share the quota.
  std::uint64_t fileBytes() const { return quota / 8; }
};

/// "2026-11-25T06-37-55Z". @param utime [us since the epoch]
std::string utcName(std::int64_t utime);
/// Of a run's folder. @param utime [us since the epoch] @param boot_id 32 digits; empty: not known
std::string runName(std::int64_t utime, const std::string& boot_id);

/// Higher than that of any file there is.
std::int64_t nextNumber(std::span<const LogFile> files);

/// Whether the present file ends and the next one begins.
bool isFull(Duration age, std::uint64_t bytes, const LogLimits& limits);

/// Whether there is room to write: not below the floor, and after that only once a tenth more is free.
/// @param writing whether there was
bool hasRoom(std::uint64_t free, std::uint64_t floor, bool writing);

/// Which closed files go, as indices: the oldest first, marked ones last. To keep the floor, unmarked ones alone, and
/// none where that would not help: then it is not the logs that fill the disk.
/// @param closed the oldest first @param free [bytes] on the disk
std::vector<std::size_t> filesToRemove(std::span<const LogFile> closed, std::uint64_t free, const LogLimits& limits);

}  // namespace slam
