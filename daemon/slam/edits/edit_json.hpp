// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <nlohmann/json_fwd.hpp>
#include <span>
#include <string>
#include <string_view>

#include "slam/edits/map_edits.hpp"

namespace slam {

/// An edit as JSON, the argument of the command map_edit (docs/api.md): {"kind": "free", "points": [[x, y], ...]}.
/// @throws std::runtime_error with one sentence where it is none; its geometry is for problemWith()
EditRequest editRequestOf(std::string_view json);
/// The edits of a map that are in effect, as a JSON list; also for other programs.
std::string editsJson(const MapEdits& edits, const KeyframeGraph& keyframes, std::span<const char> in_map);
/// What an edit is, without its points.
nlohmann::json propertiesOf(const MapEdit& edit, const KeyframeGraph& keyframes);
/// Points as a list of [x, y].
nlohmann::json listOf(const Outline& points);

}  // namespace slam
