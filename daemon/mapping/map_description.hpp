// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <array>
#include <cstdint>
#include <string>

#include "core/pose2.hpp"
#include "mapping/map_image.hpp"

namespace slam {

/// What the .yaml of a map_server pair has of its picture.
struct MapDescription {
  /// How a grey value is read: by two thresholds; the same with shades between them; as the occupancy in percent.
  enum class Mode : std::uint8_t { kTrinary, kScale, kRaw };

  std::string image;        ///< the picture's file, from the .yaml's folder
  double resolution = 0.0;  ///< [m]
  Pose2 T_map_picture;      ///< the lower left corner of the lower left cell
  Mode mode = Mode::kTrinary;
  bool negate = false;                                       ///< white is occupied, not in Mode::kRaw
  double occupied_threshold = MapImage::kOccupiedThreshold;  ///< [1] more is occupied
  double free_threshold = MapImage::kFreeThreshold;          ///< [1] less is free
};

/// Reads YAML as map_server does; keys that it has no use for are passed over. Numbers are finite, no more is checked.
/// @throws std::runtime_error with the line or the key, and what is wrong with it
MapDescription parseMapDescription(const std::string& yaml);

/// What each of the 256 grey values stands for, among MapImage's three values. Shades and percents are parted by
/// MapImage's own thresholds.
std::array<std::uint8_t, 256> cellsOfGreys(const MapDescription& description);

/// The .yaml of a picture in MapImage's three values, with as few digits as its numbers need.
/// @param picture name of its file, as the .yaml has it
std::string encodeYaml(const std::string& picture, const MapImage& image);

}  // namespace slam
