// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <cstdint>
#include <string>
#include <vector>

#include "config/config.hpp"

namespace slam {

/// The effective configuration, with its hidden keys, as TOML that loadConfig() reads back to the same values.
std::string printConfig(const Config& config);

/// A key with its value.
struct Setting {
  std::string key;    ///< section.key
  std::string value;  ///< as TOML has it
  bool operator==(const Setting&) const = default;
};
/// Every key of a configuration in its order, the password among them.
std::vector<Setting> settingsOf(const Config& config);

enum class TemplateKeys : std::uint8_t { kShown, kAll };

/// Keys with meaning, unit, range and default, commented out. Of the shown keys this is config/slamd.toml.
std::string printTemplate(TemplateKeys keys = TemplateKeys::kShown);

/// docs/tuning.md: the shown keys with default, meaning, and when to change them.
std::string printTuning();

}  // namespace slam
