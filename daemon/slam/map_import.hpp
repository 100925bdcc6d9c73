// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include "mapping/map_image.hpp"
#include "slam/map_state.hpp"

namespace slam {

/// A floor plan as a map. Its keyframes are squares of a few metres, with the border cells of the
/// walls as points and normals towards free space, each in the square's centre with the map's axes. They are fixed to
/// each other by no edge: such a map serves localisation alone.
MapState importMap(const MapImage& image);

}  // namespace slam
