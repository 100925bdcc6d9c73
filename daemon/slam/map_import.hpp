// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include "mapping/map_image.hpp"
#include "posegraph/keyframe_graph.hpp"

namespace slam {

/// Keyframes that stand for a map of which only the picture is known: the border cells of its walls as points, with
/// normals towards free space, in squares of a few metres, each a keyframe whose base is the square's centre with the
/// map's axes. They are fixed to each other by no edge: such a map serves localisation alone.
KeyframeGraph importMap(const MapImage& image);

}  // namespace slam
