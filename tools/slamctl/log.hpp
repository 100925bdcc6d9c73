// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <cstdint>
#include <filesystem>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>

/// `slamctl log`: the field logs of a folder. Needs no slamd: a log is there to be read when it is dead.
namespace slam {

/// Prints all files of the logs, the oldest first.
void printLogs(const std::filesystem::path& folder);
/// The same for programs: a list of run, file, bytes, utime [us since the epoch] (null: no whole record in it), marks.
nlohmann::json logsJson(const std::filesystem::path& folder);

/// What a person means by --since. @param text "90s", "10min", "2h", "3d": so long ago; or a UTC time, such as
/// "2026-11-25 06:37" or "2026-11-25T06:37:55Z" @param now [us since the epoch]
/// @return [us since the epoch] @throws std::runtime_error naming what can be written
std::int64_t sinceTime(const std::string& text, std::int64_t now);

/// "2025-11-25 06:37:55" in UTC; "-" for 0. @param utime [us since the epoch]
std::string timeText(std::int64_t utime);

/// [us since the epoch] of the newest record of the newest log that has one. @throws as exportLogs()
std::optional<std::int64_t> newestTime(const std::filesystem::path& folder);

struct LogExport {
  std::uint64_t records = 0, files = 0;
  std::int64_t first = 0, last = 0;  ///< [us since the epoch] of the records
};

/// Writes the whole records of all files, or those since a time, into one plain log that lcm-logplayer reads, too. It
/// begins with the configuration, so that slam-replay needs nothing else.
/// @param since [us since the epoch] @param out is never overwritten
/// @throws std::runtime_error where there is none, or the file cannot be written
LogExport exportLogs(const std::filesystem::path& folder, std::optional<std::int64_t> since,
                     const std::filesystem::path& out);

}  // namespace slam
