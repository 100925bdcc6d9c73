// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <filesystem>
#include <stdexcept>
#include <string>
#include <vector>

#include "config/config.hpp"
#include "config/service_reach.hpp"

namespace slam {

/// All that is wrong with a configuration, one line each: `file:line:column: key: what; fix`.
class ConfigError : public std::runtime_error {
 public:
  explicit ConfigError(const std::vector<std::string>& problems);
};

/// Reads a TOML file over the defaults.
/// @param overrides `section.key=value` each, applied over the file (command line option --set)
/// @param reach of the service that the configuration is for; nullptr: for whoever may reach anything
/// @throws ConfigError naming every unknown key, wrong type and value out of range at once
Config loadConfig(const std::filesystem::path& file, const std::vector<std::string>& overrides = {},
                  const ServiceReach* reach = nullptr);

/// The same from text; `name` stands for the file in messages.
Config parseConfig(const std::string& text, const std::string& name, const std::vector<std::string>& overrides = {},
                   const ServiceReach* reach = nullptr);

/// Sets over `config` what a text has. What no single key can be asked for is not looked at.
/// @return the keys that it sets, as section.key
/// @throws ConfigError, with `config` as it was
std::vector<std::string> setFrom(const std::string& text, const std::string& name, Config& config);

}  // namespace slam
