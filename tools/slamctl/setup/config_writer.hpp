// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <filesystem>
#include <string>
#include <vector>

#include "config/config.hpp"

namespace slam {

/// What a set-up changes, a line each: "lidar.x = 0.05, was 0.0". A password is not printed.
std::vector<std::string> changedSettings(const Config& before, const Config& after);

/// Writes a configuration file, whole or not at all: beside it first, on the disk, and read back to the same values by
/// the reader of configurations; then it takes the file's place. A file that was there is kept as FILE.old, or
/// FILE.old2 and so on, and its owner and rights are those of the new one.
/// @param text of editedConfig() @param wanted what it is to be read back to
/// @return where the old file is; empty: there was none @throws std::runtime_error, ConfigError
std::filesystem::path writeConfig(const std::filesystem::path& file, const std::string& text, const Config& wanted);

}  // namespace slam
