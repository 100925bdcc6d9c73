// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <cstdint>
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <sys/types.h>
#include <vector>

#include "config/service_reach.hpp"
#include "core/timestamp.hpp"

namespace slam {

/// Whom the rights and limits that slamd needs are asked of: who runs slamd, which is seldom who runs a tool.
struct Account {
  enum Source : std::uint8_t {
    kProcess,  ///< of a slamd that runs
    kUnit,     ///< of slamd.service, which would be started
    kCaller    ///< who runs this program: there is no service here
  } source = kCaller;
  std::string id;           ///< of the process below /proc; empty: none runs
  bool is_service = false;  ///< the process is slamd.service's, or would be
  uid_t user = 0;
  gid_t group = 0;
  std::vector<gid_t> groups;     ///< all further ones
  bool overrides_modes = false;  ///< CAP_DAC_OVERRIDE
  ServiceAccount unit;           ///< limits, where no process has them

  bool has(gid_t wanted) const;
  std::string userName() const;
  std::string groupName() const;
  /// "slamd (process 812, user slamd)", to begin a sentence with.
  std::string words() const;
};

Account callerAccount();
/// @param id of the process @return std::nullopt: it has gone
std::optional<Account> accountOfProcess(const std::string& id, const std::filesystem::path& root = "/");
/// @return std::nullopt: this computer has no such user
std::optional<Account> accountOfUnit(const ServiceAccount& unit);
/// The slamd that listens on a socket, or had it. @param socket empty: any slamd
std::optional<Account> accountOfSlamd(const std::string& socket, const std::filesystem::path& root = "/");

enum class Permission : std::uint8_t { kGranted, kRefused, kUnseen };  ///< the last: the caller may not look
/// May it read (R_OK), write (W_OK) or enter (X_OK) this file? By owner, group and mode, of the folders above it, too.
/// Where a list of rights (ACL) adds to these, who is not refused by them is not known to be.
Permission permissionOf(const Account& account, const std::filesystem::path& path, int access);

/// A letter for what the process does, as in /proc/ID/stat; 0: it has gone.
char processState(const std::string& id, const std::filesystem::path& root = "/");
/// A value of /proc/ID/status or /proc/ID/limits: what follows the name, up to the next blank; empty: none.
std::string processValue(const std::string& id, std::string_view file, std::string_view name,
                         const std::filesystem::path& root = "/");
/// How long each thread of a process has waited for the CPU since it began.
struct CpuWait {
  std::string name;
  Duration waited{0};
};
using CpuWaits = std::map<std::string, CpuWait>;  // by the threads' numbers
CpuWaits cpuWaits(const std::string& id, const std::filesystem::path& root = "/");
/// Threads of a process that have SCHED_FIFO now.
int fifoThreads(const std::string& id, const std::filesystem::path& root = "/");

}  // namespace slam
