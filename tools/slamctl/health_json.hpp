// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <nlohmann/json_fwd.hpp>
#include <slam/health_t.hpp>
#include <slam/pose_estimate_t.hpp>
#include <slam/problems_t.hpp>
#include <string>
#include <vector>

/// What slamd sends, as JSON for programs: docs/api.md describes the fields.
namespace slam {

struct Finding;

nlohmann::json poseJson(const pose_estimate_t& pose);
nlohmann::json problemJson(const problem_t& problem);
/// Of a pose; "unknown" where slamd has no such state.
std::string stateName(std::int8_t state);
/// With words and advice for each device.
nlohmann::json healthJson(const health_t& health, const problems_t& problems);

/// What a doctor found, one after another.
nlohmann::json findingsJson(const std::vector<Finding>& findings);

/// Fewer digits than a double has: a tenth of a millimetre is enough for a page. @param scale a power of ten
double rounded(double value, double scale = 1e4);
/// JSON that every program reads, whatever bytes the strings of a message have.
std::string textOf(const nlohmann::json& json);

}  // namespace slam
