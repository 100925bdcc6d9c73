// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <string>
#include <string_view>

#include "slam/map_state.hpp"

namespace slam {

/// The edits of a map as bytes, and after which of them each depth view was seen.
/// @throws std::runtime_error for what could not be read back
std::string encodeEdits(const MapState& map);
/// Puts edits into a map whose keyframes are whole, and takes what they erase out of them.
/// @param map with the keyframes and views that the edits refer to; unchanged where it throws
/// @throws std::runtime_error where the bytes cannot be such edits
void decodeEdits(std::string_view bytes, MapState& map);

}  // namespace slam
