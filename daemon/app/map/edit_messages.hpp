// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <cstdint>
#include <slam/map_edit_t.hpp>
#include <vector>

#include "slam/keyframe_map.hpp"

namespace slam {

/// A message for each edit in effect, one that says so where none is; nothing for a map that was never edited.
std::vector<map_edit_t> editMessages(const KeyframeMap& map, std::int32_t map_id);

}  // namespace slam
