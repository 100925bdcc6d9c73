// SPDX-License-Identifier: BSD-3-Clause
#include "mapping/map_files.hpp"

#include <cerrno>
#include <cmath>
#include <cstring>
#include <fstream>
#include <sstream>
#include <stdexcept>
#include <utility>

#include "core/plausibility.hpp"
#include "mapping/grey_picture.hpp"
#include "mapping/map_description.hpp"

namespace slam {
namespace {

namespace fs = std::filesystem;

/// The map with the path in blue.
ColourImage picture(const MapImage& map, std::span<const Eigen::Vector2d> path) {
  ColourImage image = colourMap(map);
  for (const Eigen::Vector2d& p : path) {
    const int column = static_cast<int>(std::floor((p.x() - map.origin_x) / map.resolution));
    const int row = static_cast<int>(std::floor((p.y() - map.origin_y) / map.resolution));
    image.set(column, map.height - 1 - row, kPathColour);
  }
  return image;
}

/// @param most [bytes] that such a file may have: a longer one is not read
std::string readText(const fs::path& file, std::int64_t most) {
  std::ifstream in;
  const std::uintmax_t size = openToRead(file, in);
  if (size > static_cast<std::uintmax_t>(most))
    refuseFile(file,
               "has " + std::to_string(size) + " bytes, more than the " + std::to_string(most) + " that it may have");
  std::ostringstream content;
  content << in.rdbuf();
  return content.str();
}

void requirePlausible(const fs::path& yaml, const MapImage& image) {
  const std::string words =
      implausibilityOfPicture(image.resolution, image.origin_x, image.origin_y, image.width, image.height);
  if (!words.empty())
    refuseFile(yaml, words + "; the map is not read; give resolution and origin in metres, near the map's own origin");
}

}  // namespace

void replaceFile(const fs::path& file, const std::string& content) {
  const fs::path temporary = file.string() + ".new";
  {
    std::ofstream out(temporary, std::ios::binary);
    out.write(content.data(), static_cast<std::streamsize>(content.size()));
    out.flush();
    if (!out) refuseFile(temporary, std::string("cannot write: ") + std::strerror(errno));
  }
  std::error_code error;
  fs::rename(temporary, file, error);
  if (error) refuseFile(file, "cannot replace: " + error.message());
}

std::string encodePgm(const MapImage& image) {
  std::ostringstream header;
  header << "P5\n" << image.width << " " << image.height << "\n255\n";
  return header.str() + std::string(reinterpret_cast<const char*>(image.cells.data()), image.cells.size());
}

void writeMapFiles(const fs::path& prefix, const MapImage& image, std::span<const Eigen::Vector2d> path) {
  replaceFile(prefix.string() + ".pgm", encodePgm(image));
  replaceFile(prefix.string() + ".yaml", encodeYaml(prefix.filename().string() + ".pgm", image));
  replaceFile(prefix.string() + ".png", encodePng(picture(image, path)));
}

MapImage readMapFiles(const fs::path& yaml) {
  MapDescription description;
  const std::string text = readText(yaml, kPlausible.text_bytes);
  try {
    description = parseMapDescription(text);
  } catch (const std::runtime_error& error) {
    refuseFile(yaml, error.what());
  }
  GreyPicture picture = readGreyPicture(yaml.parent_path() / description.image);
  const Pose2& corner = description.T_map_picture;
  MapImage image{.width = picture.width,
                 .height = picture.height,
                 .resolution = description.resolution,
                 .origin_x = corner.x,
                 .origin_y = corner.y,
                 .cells = std::move(picture.greys)};
  requirePlausible(yaml, image);
  if (!isWithin(corner.theta, kPlausible.turn))
    refuseFile(yaml, "origin: " + implausibilityOf(corner) + "; the map is not read; give its yaw in radians");
  const auto cells = cellsOfGreys(description);
  const bool raw = description.mode == MapDescription::Mode::kRaw;
  for (std::size_t i = 0; i < image.cells.size(); ++i) {
    const bool empty = !raw && !picture.see_through.empty() && picture.see_through[i];
    image.cells[i] = empty ? MapImage::kUnknown : cells[image.cells[i]];
  }
  if (corner.theta == 0.0) return image;
  try {
    image = alongAxes(image, corner.theta);
  } catch (const std::runtime_error& error) {
    refuseFile(yaml, error.what());
  }
  requirePlausible(yaml, image);
  return image;
}

}  // namespace slam
