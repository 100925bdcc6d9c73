// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <filesystem>
#include <string>
#include <vector>

namespace slam {

/// A device that claims a name below /dev, by udev's database.
struct Claimant {
  std::string name;     ///< the kernel's, such as ttyUSB0
  std::string by_path;  ///< name that stays with the USB socket, such as /dev/serial/by-path/...; empty: none
  std::string serial;   ///< number of its adapter; empty: none
};

/// All that claim a name: udev gives it to one of them, and to which one may change with each start.
/// @param root of the file system, for a test
std::vector<Claimant> claimantsOf(const std::filesystem::path& link, const std::filesystem::path& root = "/");

/// "two devices claim /dev/rplidar: ..."; empty where at most one does.
std::string describeClaimants(const std::filesystem::path& link, const std::vector<Claimant>& claimants);

}  // namespace slam
