// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <filesystem>
#include <nlohmann/json_fwd.hpp>

/// `slamctl list`: all maps of a folder, and what slamd would find damaged in them. Needs no slamd.
namespace slam {

void printMaps(const std::filesystem::path& folder);
/// The same for programs: docs/api.md describes the fields.
nlohmann::json mapsJson(const std::filesystem::path& folder);

}  // namespace slam
