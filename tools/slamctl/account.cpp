// SPDX-License-Identifier: BSD-3-Clause
#include "tools/slamctl/account.hpp"

#include <algorithm>
#include <cerrno>
#include <fstream>
#include <grp.h>
#include <iterator>
#include <pwd.h>
#include <sched.h>
#include <sstream>
#include <sys/stat.h>
#include <sys/xattr.h>
#include <unistd.h>

#include "bus/local_client.hpp"

namespace slam {
namespace {

namespace fs = std::filesystem;

constexpr unsigned long kDacOverride = 1UL << 1;  // CAP_DAC_OVERRIDE in a mask of capabilities

/// The part of /proc/.../stat behind the name, which may hold blanks and brackets itself.
std::vector<std::string> statFields(const fs::path& file) {
  std::ifstream in(file);
  const std::string text{std::istreambuf_iterator<char>(in), {}};
  const auto end = text.rfind(')');
  if (end == std::string::npos) return {};
  std::istringstream rest(text.substr(end + 1));
  return {std::istream_iterator<std::string>(rest), {}};
}

bool isOfService(const fs::path& process) {
  std::ifstream in(process / "cgroup");
  for (std::string line; std::getline(in, line);) {
    if (line.ends_with("/slamd.service")) return true;
  }
  return false;
}

Permission ofModes(const Account& account, const fs::path& path, int access) {
  struct stat file {};
  if (stat(path.c_str(), &file) != 0) return errno == EACCES ? Permission::kUnseen : Permission::kRefused;
  if (account.overrides_modes) return Permission::kGranted;
  const unsigned shift = account.user == file.st_uid ? 6 : account.has(file.st_gid) ? 3 : 0;
  const auto granted = static_cast<int>((file.st_mode >> shift) & 7U);
  if ((granted & access) == access) return Permission::kGranted;
  const bool has_list = getxattr(path.c_str(), "system.posix_acl_access", nullptr, 0) > 0;
  return has_list ? Permission::kUnseen : Permission::kRefused;
}

}  // namespace

bool Account::has(gid_t wanted) const {
  return group == wanted || std::find(groups.begin(), groups.end(), wanted) != groups.end();
}

std::string Account::userName() const {
  const passwd* found = getpwuid(user);
  return found != nullptr ? found->pw_name : std::to_string(user);
}

std::string Account::groupName() const {
  const ::group* found = getgrgid(group);
  return found != nullptr ? found->gr_name : std::to_string(group);
}

std::string Account::words() const {
  switch (source) {
    case kProcess:
      return "slamd (process " + id + ", user " + userName() + ")";
    case kUnit:
      return "slamd.service (user " + userName() + ")";
    default:
      return "this user";
  }
}

Account callerAccount() {
  Account account{
      .source = Account::kCaller, .id = {}, .user = geteuid(), .group = getegid(), .groups = {}, .unit = {}};
  account.groups.resize(static_cast<std::size_t>(std::max(0, getgroups(0, nullptr))));
  account.groups.resize(
      static_cast<std::size_t>(std::max(0, getgroups(static_cast<int>(account.groups.size()), account.groups.data()))));
  return account;
}

std::string processValue(const std::string& id, std::string_view file, std::string_view name, const fs::path& root) {
  std::ifstream in(root / "proc" / id / file);
  for (std::string line; std::getline(in, line);) {
    std::string value;
    if (line.starts_with(name) && std::istringstream(line.substr(name.size())) >> value) return value;
  }
  return "";
}

char processState(const std::string& id, const fs::path& root) {
  const auto fields = statFields(root / "proc" / id / "stat");
  return fields.empty() ? '\0' : fields.front().front();
}

int fifoThreads(const std::string& id, const fs::path& root) {
  constexpr std::size_t kPolicy = 38;  // the first field behind the name is the state
  int count = 0;
  std::error_code error;
  for (fs::directory_iterator at(root / "proc" / id / "task", error), end; !error && at != end; at.increment(error)) {
    const auto fields = statFields(at->path() / "stat");
    count += fields.size() > kPolicy && fields[kPolicy] == std::to_string(SCHED_FIFO) ? 1 : 0;
  }
  return count;
}

CpuWaits cpuWaits(const std::string& id, const fs::path& root) {
  CpuWaits waits;
  std::error_code error;
  for (fs::directory_iterator at(root / "proc" / id / "task", error), end; !error && at != end; at.increment(error)) {
    std::int64_t ran = 0, waited = 0;
    if (!(std::ifstream(at->path() / "schedstat") >> ran >> waited)) continue;
    CpuWait& wait = waits[at->path().filename().string()];
    std::getline(std::ifstream(at->path() / "comm"), wait.name);
    wait.waited = Duration(waited);
  }
  return waits;
}

std::optional<Account> accountOfProcess(const std::string& id, const fs::path& root) {
  Account account{.source = Account::kProcess, .id = id, .groups = {}, .unit = {}};
  std::ifstream status(root / "proc" / id / "status");
  bool has_user = false;
  for (std::string line, name; std::getline(status, line);) {
    std::istringstream words(line);
    words >> name;
    unsigned real = 0;
    if (name == "Uid:") has_user = static_cast<bool>(words >> real >> account.user);  // the effective one
    if (name == "Gid:") words >> real >> account.group;
    if (name == "Groups:") account.groups.assign(std::istream_iterator<gid_t>(words), std::istream_iterator<gid_t>());
    unsigned long capabilities = 0;
    if (name == "CapEff:" && words >> std::hex >> capabilities)
      account.overrides_modes = (capabilities & kDacOverride) != 0;
  }
  if (!has_user) return std::nullopt;
  account.is_service = isOfService(root / "proc" / id);
  // In a user namespace of its own, as of PrivateUsers=, a capability counts for nothing outside.
  if (account.user != 0) account.overrides_modes = false;
  return account;
}

std::optional<Account> accountOfUnit(const ServiceAccount& unit) {
  const passwd* user = getpwnam(unit.user.c_str());
  if (user == nullptr) return std::nullopt;
  Account account{.source = Account::kUnit,
                  .id = {},
                  .is_service = true,
                  .user = user->pw_uid,
                  .group = user->pw_gid,
                  .groups = {},
                  .overrides_modes = user->pw_uid == 0,
                  .unit = unit};
  int count = 256;
  account.groups.resize(static_cast<std::size_t>(count));
  getgrouplist(unit.user.c_str(), account.group, account.groups.data(), &count);
  account.groups.resize(static_cast<std::size_t>(std::clamp(count, 0, 256)));
  for (const std::string& name : unit.further_groups) {
    if (const ::group* further = getgrnam(name.c_str())) account.groups.push_back(further->gr_gid);
  }
  if (const ::group* own = getgrnam(unit.group.c_str())) account.group = own->gr_gid;
  return account;
}

std::optional<Account> accountOfSlamd(const std::string& socket, const fs::path& root) {
  if (LocalClient client; !socket.empty() && client.open(socket) == 0) {
    if (const auto peer = client.peer()) return accountOfProcess(std::to_string(*peer), root);
  }
  // Who may not connect, or finds too many waiting there, still sees whose socket it is, or that it is the service's.
  struct stat file {};
  const bool is_seen = !socket.empty() && stat(socket.c_str(), &file) == 0, is_hidden = !is_seen && errno == EACCES;
  if (!socket.empty() && ((!is_seen && !is_hidden) || LocalClient::probe(socket) == ECONNREFUSED)) return std::nullopt;
  std::error_code error;
  for (fs::directory_iterator at(root / "proc", error), end; !error && at != end; at.increment(error)) {
    const std::string id = at->path().filename().string();
    std::string name;
    if (id.find_first_not_of("0123456789") != std::string::npos || !(std::ifstream(at->path() / "comm") >> name) ||
        name != "slamd")
      continue;
    auto account = accountOfProcess(id, root);
    if (account && (socket.empty() || (is_hidden ? account->is_service : account->user == file.st_uid))) return account;
  }
  return std::nullopt;
}

Permission permissionOf(const Account& account, const fs::path& path, int access) {
  if (account.source == Account::kCaller)
    return ::access(path.c_str(), access) == 0 ? Permission::kGranted : Permission::kRefused;
  std::error_code error;
  const fs::path real = fs::canonical(path, error);  // a link's own mode counts for nothing
  if (error) return error == std::errc::permission_denied ? Permission::kUnseen : Permission::kRefused;
  fs::path above;
  for (const fs::path& part : real.parent_path()) {
    above /= part;
    if (const Permission enters = ofModes(account, above, X_OK); enters != Permission::kGranted) return enters;
  }
  return ofModes(account, real, access);
}

}  // namespace slam
