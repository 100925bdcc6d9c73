// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "problems/devices.hpp"

namespace slam {

struct RunningProgram {
  std::string id;
  std::string name;              ///< in ASCII that can be shown
  std::filesystem::path folder;  ///< below /proc
};
/// What runs here and can be seen. @param root of /proc
std::vector<RunningProgram> runningPrograms(const std::filesystem::path& root = "/");

/// A program other than the calling one that has a port open, as far as the caller may see that: root sees all, another
/// user his own. None of a pseudo-terminal, which whoever made it has open by right. Looks at each descriptor of each
/// program, some milliseconds. @param port as the kernel names it @param but the name of programs that may
std::optional<RunningProgram> holderOf(const std::string& port, const std::filesystem::path& root = "/",
                                       std::string_view but = "");

Problem heldBy(const RunningProgram& holder);
/// Why a port cannot be opened that another program has, a pseudo-terminal too, with that program's name where it can
/// be seen, or where a lock file in /run/lock has it.
/// @param path of the port, or of a link to it
Problem portInUse(const std::string& path, const std::filesystem::path& root = "/");

}  // namespace slam
