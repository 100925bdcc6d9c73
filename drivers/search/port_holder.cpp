// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/search/port_holder.hpp"

#include <algorithm>
#include <cerrno>
#include <csignal>
#include <fstream>
#include <iomanip>
#include <unistd.h>

namespace slam {

namespace fs = std::filesystem;

namespace {

constexpr int kLongestName = 20;  // [bytes] of a program, as lock files have it

/// A name is text, whatever a program has set.
std::string shown(std::string name) {
  std::replace_if(
      name.begin(), name.end(), [](char c) { return c < ' ' || c > '~'; }, '?');
  return name;
}

}  // namespace

std::vector<RunningProgram> runningPrograms(const fs::path& root) {
  std::vector<RunningProgram> programs;
  std::error_code error;
  for (fs::directory_iterator at(root / "proc", error), end; !error && at != end; at.increment(error)) {
    const std::string id = at->path().filename().string();
    if (id.find_first_not_of("0123456789") != std::string::npos) continue;
    RunningProgram& program = programs.emplace_back(RunningProgram{id, "", at->path()});
    std::ifstream comm(at->path() / "comm");
    std::getline(comm, program.name);
    program.name = shown(program.name);
  }
  return programs;
}

namespace {

/// By the lock file of terminal programs (HDB UUCP: process id, then the program's name as minicom writes it), which
/// every user may read.
std::optional<RunningProgram> programWithLock(const fs::path& port, const fs::path& root) {
  std::ifstream lock(root / "run/lock" / ("LCK.." + port.filename().string()));
  pid_t id = 0;
  std::string name;
  if (!(lock >> id) || id <= 0 || id == getpid()) return std::nullopt;
  if (kill(id, 0) != 0 && errno == ESRCH) return std::nullopt;  // it has ended without removing its file
  lock >> std::setw(kLongestName) >> name;
  return RunningProgram{std::to_string(id), name.empty() ? "?" : shown(name), {}};
}

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
  auto holder = error ? std::nullopt : programWith(device.string(), root, "");
  if (!holder && !error) holder = programWithLock(device, root);
  return holder ? heldBy(*holder) : problem::kPortInUse;
}

}  // namespace slam
