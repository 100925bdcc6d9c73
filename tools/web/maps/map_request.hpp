// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>

#include "tools/web/request_guard.hpp"

namespace slam {

/// Commands about maps and what is drawn into them (docs/api.md), as slamctl sends them. Pure.
/// @param request a JSON object @param verb of it
/// @return std::nullopt for what is none of them, with `problem` empty, or for a wrong one, with what is wrong
std::optional<WebCommand> mapRequestOf(const nlohmann::json& request, const std::string& verb, Answer& problem);

}  // namespace slam
