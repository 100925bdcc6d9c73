// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <string>

#include "tools/web/web_state.hpp"

namespace slam {

/// What slamd is and how it does, for Prometheus: its text format 0.0.4. Units stand in the names.
std::string metricsText(const WebState& state, const std::string& version, Timestamp now);

}  // namespace slam
