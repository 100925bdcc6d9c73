// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <exception>
#include <filesystem>
#include <string>

namespace slam {

/// Why a disk does not take what is written, and what helps.
struct DiskWords {
  std::string cause, fix;
};

/// @param error that writing has thrown @param folder that all of it belongs into
DiskWords diskWords(const std::exception& error, const std::filesystem::path& folder);

}  // namespace slam
