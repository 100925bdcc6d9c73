// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/search/port_holder.hpp"

#include <algorithm>
#include <fstream>
#include <unistd.h>

namespace slam {

namespace fs = std::filesystem;

std::vector<RunningProgram> runningPrograms(const fs::path& root) {
  std::vector<RunningProgram> programs;
  std::error_code error;
  for (fs::directory_iterator at(root / "proc", error), end; !error && at != end; at.increment(error)) {
    const std::string id = at->path().filename().string();
    if (id.find_first_not_of("0123456789") != std::string::npos) continue;
    RunningProgram& program = programs.emplace_back(RunningProgram{id, "", at->path()});
    std::ifstream comm(at->path() / "comm");
    std::getline(comm, program.name);
    std::replace_if(
        program.name.begin(), program.name.end(), [](char c) { return c < ' ' || c > '~'; }, '?');
  }
  return programs;
}

namespace {

std::optional<RunningProgram> programWith(const std::string& port, const fs::path& root, std::string_view but) {
  const std::string own = std::to_string(getpid());
  for (RunningProgram& program : runningPrograms(root)) {
    if (program.id == own || (!but.empty() && program.name == but)) continue;
    std::error_code error;
    for (fs::directory_iterator at(program.folder / "fd", error), end; !error && at != end; at.increment(error)) {
      std::error_code ignored;
      if (fs::read_symlink(at->path(), ignored) == port) return std::move(program);
    }
  }
  return std::nullopt;
}

}  // namespace

std::optional<RunningProgram> holderOf(const std::string& port, const fs::path& root, std::string_view but) {
  if (port.starts_with("/dev/pts/")) return std::nullopt;
  return programWith(port, root, but);
}

Problem heldBy(const RunningProgram& holder) { return {problem::kPortHeld, {}, {holder.name, holder.id}}; }

Problem portInUse(const std::string& path, const fs::path& root) {
  std::error_code error;
  const fs::path device = fs::canonical(path, error);
  const auto holder = error ? std::nullopt : programWith(device.string(), root, "");
  return holder ? heldBy(*holder) : problem::kPortInUse;
}

}  // namespace slam
