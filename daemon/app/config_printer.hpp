// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <string>

#include "app/config.hpp"

namespace slam {

/// The effective configuration as TOML that loadConfig() reads back to the same values.
std::string printConfig(const Config& config);

/// config/slamd.toml: every key with meaning, unit, range and default, commented out.
std::string printTemplate();

}  // namespace slam
