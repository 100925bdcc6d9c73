// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <stdexcept>
#include <string>
#include <string_view>

#include "slam/map_state.hpp"
#include "store/binary.hpp"

/// Parts of a map as bytes and back. Reading throws std::runtime_error where the bytes cannot be such a part: numbers
/// that are not plausible and ids out of range are refused. Writing throws the same for what could not be read back.
namespace slam {

/// A number of a map is beyond what can be true of one.
struct ImplausibleMap : std::runtime_error {
  using std::runtime_error::runtime_error;
};

void encodeNode(BinaryWriter& out, const StoredScan& scan, const Pose2& T_map_base, bool in_map);
void encodeEdge(BinaryWriter& out, const Edge& edge);
void encodePoses(BinaryWriter& out, std::span<const Pose2> poses);
void encodeView(BinaryWriter& out, const MapView& view);
/// Adds a node to a map.
void decodeNode(BinaryReader& in, MapState& map);
/// Adds an edge between nodes of a map.
void decodeEdge(BinaryReader& in, MapState& map);
/// Moves the nodes of a map.
void decodePoses(BinaryReader& in, MapState& map);
/// @param map that the view's keyframe is in
MapView decodeView(BinaryReader& in, const MapState& map);

std::string encodeKeyframes(const MapState& map);
void decodeKeyframes(std::string_view bytes, MapState& map);
std::string encodeEdges(const MapState& map);
void decodeEdges(std::string_view bytes, MapState& map);

/// Log-odds of the lidar layer tile by tile, compressed.
std::string encodeGrid(const OccupancyGrid& grid);
/// @param config of the grid to make; its resolution is the stored one
OccupancyGrid decodeGrid(std::string_view bytes, OccupancyGridConfig config);

/// Depth layer as encodeGrid does, and the views kept.
std::string encodeDepth(const MapState& map);
/// @param map with keyframes and a grid of the same resolution; unchanged where it throws
void decodeDepth(std::string_view bytes, MapState& map);

/// Last pose, bias and calibration, as TOML for people to read.
std::string encodeState(const MapState& map);
/// @param map unchanged where it throws
void decodeState(std::string_view text, MapState& map);

}  // namespace slam
