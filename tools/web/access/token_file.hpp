// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <string>

#include "config/config.hpp"

namespace slam {

/// The token of the page: web.token, or else what web.token_file holds. Empty where nothing needs one.
/// @throws ConfigError, with the fix, where one is needed, and there is none or one that could be guessed
std::string tokenOf(const WebConfig& web);

}  // namespace slam
