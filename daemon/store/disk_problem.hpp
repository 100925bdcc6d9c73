// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <exception>
#include <filesystem>

#include "problems/daemon.hpp"

namespace slam {

/// Why a disk does not take what is written. @param error that writing has thrown @param folder that all of it belongs
/// into
Problem diskProblem(const std::exception& error, const std::filesystem::path& folder);

}  // namespace slam
