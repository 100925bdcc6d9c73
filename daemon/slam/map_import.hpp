// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include "mapping/map_image.hpp"
#include "matching/match_result.hpp"
#include "slam/map_state.hpp"

namespace slam {

/// A map of which only the picture is known. Its keyframes are squares of a few metres, with the border cells of the
/// walls as points and normals towards free space, each in the square's centre with the map's axes. They are fixed to
/// each other by no edge: such a map serves localisation alone.
MapState importMap(const MapImage& image);

/// Settings of the matchers in such a map: a wall may lie half a cell beside its cell's centre.
MatchConfig matchInPicture(MatchConfig match, double resolution);

}  // namespace slam
