// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <string>

#include "config/config.hpp"

namespace slam {

/// The text of a configuration file that is read back to the wanted values: a text with the values changed where it
/// differs, and nothing else, neither its comments nor its order. A key that a template shows behind a # stands there
/// afterwards. Where that cannot be done (a section that is written as keys with dots), it is the template with the
/// values filled in.
/// @param text of the file so far; empty: the template
/// @throws std::runtime_error where the values cannot stand in one file
std::string editedConfig(const std::string& text, const Config& wanted);

}  // namespace slam
