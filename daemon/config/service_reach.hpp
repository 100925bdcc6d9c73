// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "config/config.hpp"

namespace slam {

/// What slamd.service is started with.
inline constexpr const char* kServiceConfig = "/etc/slamd/slamd.toml";
bool isServiceConfig(const std::filesystem::path& file);

/// Who slamd.service is, and what its limits are, as the unit has them; by the unit as it is delivered at first.
struct ServiceAccount {
  std::string user = "slamd", group = "slamd";
  std::vector<std::string> further_groups = {"dialout", "video"};  ///< SupplementaryGroups=
  std::string priority_limit = "95", lock_limit = "infinity";      ///< LimitRTPRIO=; LimitMEMLOCK= [bytes]
  bool realtime_refused = false;                                   ///< RestrictRealtime=
};

/// Which files slamd.service may read and write, and as whom, by the unit that is installed and its drop-ins; by the
/// unit as it is delivered where none is.
class ServiceReach {
 public:
  /// A path of the configuration that the service cannot use.
  struct Problem {
    const char* key;   ///< section.key
    std::string what;  ///< empty: the service may use it
    std::string fix;
  };

  /// @param root of the file system that the unit is installed in
  explicit ServiceReach(const std::filesystem::path& root = "/");

  std::vector<Problem> problemsOf(const Config& config) const;
  const ServiceAccount& account() const { return account_; }
  const std::filesystem::path& workingDirectory() const { return working_directory_; }

 private:
  using Paths = std::vector<std::filesystem::path>;
  enum class Homes : std::uint8_t { kShown, kReadOnly, kEmpty, kHidden };  // ProtectHome=
  enum class Access : std::uint8_t { kReads, kWrites, kWritesInto };       // the last: a folder

  void read(const std::filesystem::path& file);
  void set(const std::string& key, const std::string& value);
  Problem problemOf(const char* key, const std::filesystem::path& path, Access access) const;
  std::string fixFor(const std::filesystem::path& folder, bool at_home) const;

  bool strict_ = true, private_tmp_ = true;
  Homes homes_ = Homes::kHidden;
  std::filesystem::path working_directory_ = "/var/lib/slamd";
  Paths own_ = {"/var/lib/slamd", "/run/slamd"}, writable_, bound_;
  ServiceAccount account_;
};

}  // namespace slam
