// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <atomic>
#include <cstdint>
#include <string>

#include "tools/web/web_state.hpp"

namespace slam {

/// Of Foxglove's connections.
struct FoxgloveCounts {
  std::atomic<std::uint64_t> clients{0};
  std::atomic<std::uint64_t> dropped_messages{0};  ///< of clients that read too slowly
  std::atomic<std::uint64_t> ended_clients{0};     ///< who took nothing, sent too much that is wrong, or made place
};

/// What slamd is and how it does, for Prometheus: its text format 0.0.4. Units stand in the names.
std::string metricsText(const WebState& state, const FoxgloveCounts& foxglove, const std::string& version,
                        Timestamp now);

}  // namespace slam
