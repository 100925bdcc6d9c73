// SPDX-License-Identifier: BSD-3-Clause
#include "tools/slamctl/setup/config_writer.hpp"

#include <cerrno>
#include <cstring>
#include <stdexcept>
#include <sys/stat.h>
#include <unistd.h>

#include "config/loader.hpp"
#include "config/printer.hpp"
#include "store/durable_file.hpp"
#include "tools/common/output_file.hpp"

namespace slam {
namespace {

namespace fs = std::filesystem;

fs::path freeName(const fs::path& file) {
  fs::path old = file.string() + ".old";
  for (int number = 2; fs::exists(old); ++number) old = file.string() + ".old" + std::to_string(number);
  return old;
}

/// Owner and rights of a file for another one: a configuration may hold a password. @return false: not permitted
bool takeRights(const fs::path& from, const fs::path& to) {
  struct stat status {};
  if (stat(from.c_str(), &status) != 0) return false;
  if (chown(to.c_str(), status.st_uid, status.st_gid) != 0) return false;
  return chmod(to.c_str(), status.st_mode & 07777) == 0;
}

}  // namespace

std::vector<std::string> changedSettings(const Config& before, const Config& after) {
  const auto old = settingsOf(before), now = settingsOf(after);
  std::vector<std::string> lines;
  for (std::size_t i = 0; i < now.size(); ++i) {
    if (old[i] == now[i]) continue;
    const bool secret = now[i].key == "web.token";
    lines.push_back(now[i].key + (secret ? " is another one" : " = " + now[i].value + ", was " + old[i].value));
  }
  return lines;
}

fs::path writeConfig(const fs::path& target, const std::string& text, const Config& wanted) {
  std::error_code error;
  const bool there = fs::exists(target, error);
  const fs::path file = there ? fs::canonical(target) : fs::absolute(target);  // a link stays one
  prepareOutput(file);
  Replacement next(file);
  const fs::path& draft = next.draft();
  writeDurably(draft, text, there ? 0600 : 0666);  // until it has the rights of the one before
  if (there && !takeRights(file, draft))
    throw std::runtime_error(draft.string() + ": it cannot get the owner and rights of " + file.string() + ": " +
                             std::strerror(errno) + "; run slamctl setup with sudo");
  if (settingsOf(loadConfig(draft)) != settingsOf(wanted))
    throw std::runtime_error(draft.string() + ": it is not read back to what was written");
  fs::path old;
  if (there) {
    old = freeName(file);
    fs::create_hard_link(file, old, error);
    if (error) fs::copy_file(file, old);
  }
  next.putInPlace();
  return old;
}

}  // namespace slam
