// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <Eigen/Core>
#include <filesystem>
#include <span>
#include <string>

#include "mapping/colour_image.hpp"
#include "mapping/map_description.hpp"
#include "mapping/map_image.hpp"

namespace slam {

/// Writes a file beside its place and renames it, so that a crash leaves the old one whole.
/// @throws std::runtime_error with file and reason
void replaceFile(const std::filesystem::path& file, const std::string& content);

/// The picture of a map_server pair.
std::string encodePgm(const MapImage& image);

/// Writes PREFIX.yaml, PREFIX.pgm (the pair that map_server loads) and PREFIX.png (for people, with the path in blue).
/// Each file is written beside its place and renamed, so that a crash leaves the old one whole.
/// @param path [m] positions in map to draw into the PNG; may be empty
/// @throws std::runtime_error with file and reason when a file cannot be written
void writeMapFiles(const std::filesystem::path& prefix, const MapImage& image,
                   std::span<const Eigen::Vector2d> path = {});

/// Reads a map_server pair: what parseMapDescription() and readGreyPicture() do. What is no file, as a pipe, is refused
/// and not waited for. Its numbers are held to PlausibilityLimits. A picture with a yaw is drawn anew along the axes;
/// what is not opaque is unknown.
/// @throws std::runtime_error with file and reason
MapImage readMapFiles(const std::filesystem::path& yaml);

}  // namespace slam
