// SPDX-License-Identifier: BSD-3-Clause
#include "config/service_reach.hpp"

#include <algorithm>
#include <fstream>
#include <initializer_list>
#include <map>
#include <sstream>

namespace slam {
namespace {

namespace fs = std::filesystem;

constexpr const char* kUnit = "slamd.service";
// As in systemd.unit(5), the strongest first.
constexpr std::initializer_list<const char*> kUnitFolders = {"etc/systemd/system", "run/systemd/system",
                                                             "usr/local/lib/systemd/system", "usr/lib/systemd/system",
                                                             "lib/systemd/system"};
constexpr std::initializer_list<const char*> kHomes = {"/home", "/root", "/run/user"};
constexpr std::initializer_list<const char*> kTemporary = {"/tmp", "/var/tmp"};

bool isBelow(const fs::path& path, const fs::path& folder) {
  return std::mismatch(folder.begin(), folder.end(), path.begin(), path.end()).first == folder.end();
}

template <typename Folders>
bool isBelowAny(const fs::path& path, const Folders& folders) {
  return std::any_of(folders.begin(), folders.end(), [&](const fs::path& folder) { return isBelow(path, folder); });
}

bool isYes(const std::string& value) { return value == "yes" || value == "true" || value == "on" || value == "1"; }

/// Without the last slash, which would be an element of its own.
fs::path folderOf(std::string text) {
  while (text.size() > 1 && text.back() == '/') text.pop_back();
  return text;
}

/// Appends the words of a list; an empty one empties what was there, as systemd has it.
template <typename ToPath>
void append(std::vector<fs::path>& paths, const std::string& list, ToPath&& toPath) {
  if (list.empty()) paths.clear();
  std::istringstream words(list);
  for (std::string word; words >> word;) {
    std::erase(word, '"');
    paths.push_back(folderOf(toPath(word)));
  }
}

std::string withoutPrefix(const std::string& word) {
  return word.substr(std::min(word.find_first_not_of("-+"), word.size()));
}

/// SOURCE[:DESTINATION[:OPTIONS]]
std::string destinationOf(const std::string& word) {
  const std::string paths = withoutPrefix(word);
  const auto colon = paths.find(':');
  if (colon == std::string::npos) return paths;
  return paths.substr(colon + 1, paths.find(':', colon + 1) - colon - 1);
}

}  // namespace

bool isServiceConfig(const fs::path& file) {
  std::error_code ignored;
  return fs::weakly_canonical(fs::absolute(file, ignored), ignored) == kServiceConfig;
}

ServiceReach::ServiceReach(const fs::path& root) {
  std::error_code ignored;
  const auto unit = std::find_if(kUnitFolders.begin(), kUnitFolders.end(),
                                 [&](const char* folder) { return fs::exists(root / folder / kUnit, ignored); });
  if (unit != kUnitFolders.end()) {
    strict_ = private_tmp_ = false;
    homes_ = Homes::kShown;
    working_directory_ = "/";
    own_.clear();
    account_ = {.user = "root", .group = "", .further_groups = {}, .priority_limit = "0", .lock_limit = "8M"};
    read(root / *unit / kUnit);
  }
  std::map<std::string, fs::path> drop_ins;  // read in the order of their names; the stronger folder's, of one name
  for (const char* folder : kUnitFolders) {
    for (const fs::directory_entry& file : fs::directory_iterator(root / folder / (std::string(kUnit) + ".d"), ignored))
      if (file.path().extension() == ".conf") drop_ins.emplace(file.path().filename(), file.path());
  }
  for (const auto& [name, file] : drop_ins) read(file);
}

void ServiceReach::read(const fs::path& file) {
  std::ifstream in(file);
  for (std::string line; std::getline(in, line);) {
    const auto equals = line.find('=');
    if (equals == std::string::npos || line[0] == '#' || line[0] == ';') continue;
    const auto trimmed = [](const std::string& text) {
      const auto first = text.find_first_not_of(" \t"), last = text.find_last_not_of(" \t\r");
      return first == std::string::npos ? std::string() : text.substr(first, last - first + 1);
    };
    set(trimmed(line.substr(0, equals)), trimmed(line.substr(equals + 1)));
  }
}

void ServiceReach::set(const std::string& key, const std::string& value) {
  if (key == "ProtectSystem") strict_ = value == "strict";
  if (key == "ProtectHome") {
    homes_ = isYes(value)           ? Homes::kHidden
             : value == "tmpfs"     ? Homes::kEmpty
             : value == "read-only" ? Homes::kReadOnly
                                    : Homes::kShown;
  }
  if (key == "PrivateTmp") private_tmp_ = isYes(value) || value == "disconnected";
  if (key == "User") account_.user = value.empty() ? "root" : value;
  if (key == "Group") account_.group = value;
  if (key == "LimitRTPRIO") account_.priority_limit = value;
  if (key == "LimitMEMLOCK") account_.lock_limit = value;
  if (key == "RestrictRealtime") account_.realtime_refused = isYes(value);
  if (key == "SupplementaryGroups") {
    if (value.empty()) account_.further_groups.clear();
    std::istringstream words(value);
    for (std::string word; words >> word;) account_.further_groups.push_back(word);
  }
  if (key == "WorkingDirectory") working_directory_ = folderOf(withoutPrefix(value));
  if (key == "ReadWritePaths") append(writable_, value, withoutPrefix);
  if (key == "BindPaths") append(bound_, value, destinationOf);
  for (const auto& own : {std::pair("StateDirectory", "/var/lib/"),
                          {"RuntimeDirectory", "/run/"},
                          {"CacheDirectory", "/var/cache/"},
                          {"LogsDirectory", "/var/log/"}}) {
    if (key != own.first) continue;
    append(own_, value, [&](const std::string& word) { return own.second + word.substr(0, word.find(':')); });
  }
}

ServiceReach::Problem ServiceReach::problemOf(const char* key, const fs::path& given, Access access) const {
  std::error_code error;
  const fs::path absolute = (given.is_absolute() ? given : working_directory_ / given).lexically_normal();
  const fs::path real = fs::weakly_canonical(absolute, error);  // a link may lead out of what may be reached
  const fs::path path = error ? absolute : real;
  const fs::path folder = access == Access::kWritesInto ? path : path.parent_path();
  const bool at_home = isBelowAny(path, kHomes), writes = access != Access::kReads;
  const Problem hidden{key, "slamd.service cannot reach " + path.string(), fixFor(folder, true)}, none{key, "", ""};
  if (at_home && homes_ == Homes::kHidden) return hidden;
  if (isBelowAny(path, own_) || isBelowAny(path, bound_)) return none;
  if (at_home && homes_ == Homes::kEmpty) return hidden;
  if (private_tmp_ && isBelowAny(path, kTemporary)) {
    return {key, "slamd.service has a /tmp and /var/tmp of its own, which nobody else sees and which end with it",
            fixFor(folder, false)};
  }
  const bool protects = strict_ || (at_home && homes_ == Homes::kReadOnly);
  if (!writes || !protects || isBelowAny(path, writable_)) return none;
  return {key, "slamd.service may not write " + path.string(), fixFor(folder, false)};
}

std::string ServiceReach::fixFor(const fs::path& folder, bool at_home) const {
  const std::string allowed = at_home                          ? "ProtectHome=tmpfs and BindPaths="
                              : isBelowAny(folder, kTemporary) ? "PrivateTmp=no and ReadWritePaths="
                                                               : "ReadWritePaths=";
  return "use a path below " + (own_.empty() ? std::string("/var/lib/slamd") : own_.front().string()) +
         ", or run sudo systemctl edit slamd, write " + allowed + folder.string() +
         " into [Service], and let user slamd write there";
}

std::vector<ServiceReach::Problem> ServiceReach::problemsOf(const Config& config) const {
  const std::string& map = config.store.map;
  const std::string& uri = config.depth_device.uri;
  std::vector<Problem> problems;
  const auto check = [&](const char* key, const std::string& path, Access access) {
    if (path.empty()) return;
    if (Problem problem = problemOf(key, path, access); !problem.what.empty()) problems.push_back(std::move(problem));
  };
  check("store.directory", config.store.directory, Access::kWritesInto);
  check("store.map", map.find('/') == std::string::npos ? "" : map, Access::kReads);  // else a name in the folder
  check("depth.uri", uri.starts_with('/') ? uri : "", Access::kReads);
  check("depth.record", config.depth_device.record, Access::kWrites);
  check("runtime.socket", config.runtime.socket, Access::kWrites);
  check("output.map", config.output.map, Access::kWrites);
  check("log.directory", config.log.directory, Access::kWritesInto);
  check("output.record", config.output.record, Access::kWrites);
  return problems;
}

}  // namespace slam
