// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <atomic>
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

/// Field logs on the disk: FOLDER/RUN/NNNN.lcm, NNNN.lcm.gz once it is closed, NNNN.oni of the camera's images, and
/// NNNN.mark with a person's words. The numbers go on from run to run, so that they give the order whatever the clock
/// says.
namespace slam {

struct LogFile {
  std::filesystem::path path;  ///< of the log: the compressed one where both are there; or of images
  std::int64_t number = 0;
  std::uint64_t bytes = 0;  ///< of all that has this number
  bool marked = false;

  std::string run() const { return path.parent_path().filename(); }
  bool isLog() const { return path.extension() != ".oni"; }
};

/// All files of a folder of logs, or of one run, the oldest first. What a power cut has left half done is no file.
/// @throws std::runtime_error where the folder cannot be read
std::vector<LogFile> logFilesIn(const std::filesystem::path& folder);

/// The logs among what a person names, in order: files as they are, folders by what is in them.
/// @throws std::runtime_error for a folder that cannot be read, or holds no log
std::vector<std::filesystem::path> logPaths(const std::vector<std::filesystem::path>& given);

/// A person's words about what is in a file, one a line; empty where there are none.
std::string markOf(const LogFile& file);

std::filesystem::path logPath(const std::filesystem::path& run, std::int64_t number);   ///< NNNN.lcm
std::filesystem::path markPath(const std::filesystem::path& run, std::int64_t number);  ///< NNNN.mark

/// Removes a file with its mark.
/// @throws std::filesystem::filesystem_error
void removeLog(const LogFile& file);

/// Removes what a power cut has left: compressed files that are not whole, plain ones whose compressed one is, files
/// without a byte, and empty runs.
/// @param present the run that is written: it and its files may be empty
void tidyLogs(const std::filesystem::path& folder, const std::filesystem::path& present);

/// Turns NNNN.lcm into NNNN.lcm.gz. At no moment is there neither of them.
/// @param cancel true: leaves the plain file
/// @throws std::runtime_error
void compressLog(const std::filesystem::path& file, const std::atomic<bool>& cancel);

}  // namespace slam
