// SPDX-License-Identifier: BSD-3-Clause
#include "mapping/map_files.hpp"

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <fstream>
#include <iomanip>
#include <optional>
#include <sstream>
#include <stdexcept>

#include "core/plausibility.hpp"

namespace slam {
namespace {

namespace fs = std::filesystem;

[[noreturn]] void fail(const fs::path& file, const std::string& what) {
  throw std::runtime_error(file.string() + ": " + what);
}

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

/// @return its size [bytes]
std::uintmax_t open(const fs::path& file, std::ifstream& in) {
  std::error_code error;
  const fs::file_status status = fs::status(file, error);
  if (fs::exists(status) && !fs::is_regular_file(status)) fail(file, "cannot read: it is no file");
  in.open(file, std::ios::binary);
  if (!in) fail(file, std::string("cannot read: ") + std::strerror(errno));
  return fs::file_size(file);
}

/// @param most [bytes] that such a file may have: a longer one is not read
std::string readText(const fs::path& file, std::int64_t most) {
  std::ifstream in;
  const std::uintmax_t size = open(file, in);
  if (size > static_cast<std::uintmax_t>(most))
    fail(file, "has " + std::to_string(size) + " bytes, more than the " + std::to_string(most) + " that it may have");
  std::ostringstream content;
  content << in.rdbuf();
  return content.str();
}

/// Width, height and maximum of a PGM, with comments between them; leaves the stream at its first pixel.
void readHeader(const fs::path& pgm, std::istream& in, MapImage& image) {
  std::string magic(2, '\0');
  int max_value = 0;
  in.read(magic.data(), 2);
  for (int* number : {&image.width, &image.height, &max_value}) {
    while ((in >> std::ws).peek() == '#') in.ignore(4096, '\n');
    in >> *number;
  }
  in.get();  // one blank
  if (!in || magic != "P5" || max_value != 255 || image.width <= 0 || image.height <= 0) {
    fail(pgm,
         "not a binary 8-bit PGM (P5, greatest value 255), the only picture of a map that slamd reads; convert it");
  }
}

/// The value after `key:` of a flat YAML file, as map_server writes it.
std::optional<std::string> findYamlValue(const std::string& text, const std::string& key) {
  std::istringstream lines(text);
  for (std::string line; std::getline(lines, line);) {
    if (line.rfind(key + ":", 0) != 0) continue;
    const auto begin = line.find_first_not_of(" \t", key.size() + 1);
    std::string value = begin == std::string::npos ? "" : line.substr(begin);
    const char quote = value.empty() ? '\0' : value.front();
    if (const auto end = value.find(quote, 1); (quote == '"' || quote == '\'') && end != std::string::npos) {
      return value.substr(1, end - 1);
    }
    if (const auto comment = value.find(" #"); comment != std::string::npos) value.resize(comment);
    value.resize(value.find_last_not_of(" \t\r") + 1);
    return value;
  }
  return std::nullopt;
}

std::string yamlValue(const fs::path& file, const std::string& text, const std::string& key) {
  const auto value = findYamlValue(text, key);
  if (!value) fail(file, "no line '" + key + ": ...'; slamd reads map_server files with a line for each key");
  return *value;
}

/// What this reader cannot honour must not be passed over.
void requireYaml(const fs::path& file, const std::string& text, const std::string& key, const std::string& wanted) {
  const auto value = findYamlValue(text, key);
  if (value && *value != wanted) fail(file, key + ": '" + *value + "' is not supported; only '" + wanted + "' is");
}

}  // namespace

void replaceFile(const fs::path& file, const std::string& content) {
  const fs::path temporary = file.string() + ".new";
  {
    std::ofstream out(temporary, std::ios::binary);
    out.write(content.data(), static_cast<std::streamsize>(content.size()));
    out.flush();
    if (!out) fail(temporary, std::string("cannot write: ") + std::strerror(errno));
  }
  std::error_code error;
  fs::rename(temporary, file, error);
  if (error) fail(file, "cannot replace: " + error.message());
}

std::string encodePgm(const MapImage& image) {
  std::ostringstream header;
  header << "P5\n" << image.width << " " << image.height << "\n255\n";
  return header.str() + std::string(reinterpret_cast<const char*>(image.cells.data()), image.cells.size());
}

std::string encodeYaml(const std::string& pgm, const MapImage& image) {
  std::ostringstream yaml;
  yaml << std::setprecision(17) << "image: " << pgm << "\n"
       << "mode: trinary\n"
       << "resolution: " << image.resolution << "\n"
       << "origin: [" << image.origin_x << ", " << image.origin_y << ", 0]\n"
       << "negate: 0\n"
       << std::setprecision(6) << "occupied_thresh: " << MapImage::kOccupiedThreshold << "\n"
       << "free_thresh: " << MapImage::kFreeThreshold << "\n";
  return yaml.str();
}

void writeMapFiles(const fs::path& prefix, const MapImage& image, std::span<const Eigen::Vector2d> path) {
  replaceFile(prefix.string() + ".pgm", encodePgm(image));
  replaceFile(prefix.string() + ".yaml", encodeYaml(prefix.filename().string() + ".pgm", image));
  replaceFile(prefix.string() + ".png", encodePng(picture(image, path)));
}

MapImage readMapFiles(const fs::path& yaml) {
  const std::string text = readText(yaml, kPlausible.text_bytes);
  requireYaml(yaml, text, "mode", "trinary");
  if (findYamlValue(text, "negate") != "false") requireYaml(yaml, text, "negate", "0");
  MapImage image;
  double occupied = MapImage::kOccupiedThreshold, free = MapImage::kFreeThreshold;  // [1] probabilities
  try {
    image.resolution = std::stod(yamlValue(yaml, text, "resolution"));
    std::string origin = yamlValue(yaml, text, "origin");
    for (char& c : origin) c = (c == '[' || c == ']' || c == ',') ? ' ' : c;
    std::istringstream numbers(origin);
    double yaw = 0.0;
    if (!(numbers >> image.origin_x >> image.origin_y >> yaw)) {
      fail(yaml, "origin does not stand in its line as [x, y, yaw]; write it so, also where it is a list of lines");
    }
    if (yaw != 0.0) fail(yaml, "origin: a yaw other than 0 is not supported; turn the picture and set it to 0");
    if (const auto value = findYamlValue(text, "occupied_thresh")) occupied = std::stod(*value);
    if (const auto value = findYamlValue(text, "free_thresh")) free = std::stod(*value);
  } catch (const std::logic_error&) {
    fail(yaml, "resolution or a threshold is not a number");
  }
  if (!(free <= occupied)) fail(yaml, "free_thresh is above occupied_thresh");

  const fs::path pgm = yaml.parent_path() / yamlValue(yaml, text, "image");
  std::ifstream in;
  const std::uintmax_t file_size = open(pgm, in);
  readHeader(pgm, in, image);
  const std::int64_t size = std::int64_t{image.width} * image.height;
  if (const std::string words = implausibilityOfSize(image.width, image.height); !words.empty())
    fail(pgm, words + "; the map is not read; cut off what is not known around it");
  const std::string implausible =
      implausibilityOfPicture(image.resolution, image.origin_x, image.origin_y, image.width, image.height);
  if (!implausible.empty())
    fail(yaml, implausible + "; the map is not read; give resolution and origin in metres, near the map's own origin");
  if (static_cast<std::uintmax_t>(size) > file_size) fail(pgm, "shorter than its header says");
  image.cells.resize(static_cast<std::size_t>(size));
  if (!in.read(reinterpret_cast<char*>(image.cells.data()), size)) fail(pgm, "shorter than its header says");
  for (std::uint8_t& cell : image.cells) {
    const std::uint8_t grey = cell;
    const double probability = (255 - grey) / 255.0;
    // 205 means unknown whatever the thresholds: with map_server's own of 0.25 it would be free.
    const bool unknown = grey == MapImage::kUnknown || (probability >= free && probability <= occupied);
    cell = unknown ? MapImage::kUnknown : probability < free ? MapImage::kFree : MapImage::kOccupied;
  }
  return image;
}

}  // namespace slam
