// SPDX-License-Identifier: BSD-3-Clause
#include "mapping/map_files.hpp"

#include <cerrno>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <fstream>
#include <iomanip>
#include <optional>
#include <sstream>
#include <stdexcept>

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

std::string readWhole(const fs::path& file) {
  std::ifstream in(file, std::ios::binary);
  if (!in) fail(file, std::string("cannot read: ") + std::strerror(errno));
  std::ostringstream content;
  content << in.rdbuf();
  return content.str();
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
  const std::string text = readWhole(yaml);
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
  if (!(image.resolution > 0.0)) fail(yaml, "resolution must be above 0");

  const fs::path pgm = yaml.parent_path() / yamlValue(yaml, text, "image");
  const std::string content = readWhole(pgm);
  std::istringstream header(content);
  std::string magic;
  int max_value = 0;
  header >> magic;
  while ((header >> std::ws).peek() == '#') header.ignore(4096, '\n');
  header >> image.width >> image.height >> max_value;
  if (!header || magic != "P5" || max_value != 255 || image.width <= 0 || image.height <= 0) {
    fail(pgm,
         "not a binary 8-bit PGM (P5, greatest value 255), the only picture of a map that slamd reads; convert it");
  }
  const auto begin = static_cast<std::size_t>(header.tellg()) + 1;
  const auto size = static_cast<std::size_t>(image.width) * static_cast<std::size_t>(image.height);
  if (content.size() < begin || content.size() - begin < size) fail(pgm, "shorter than its header says");
  for (std::size_t i = 0; i < size; ++i) {
    const auto grey = static_cast<std::uint8_t>(content[begin + i]);
    const double probability = (255 - grey) / 255.0;
    // 205 means unknown whatever the thresholds: with map_server's own of 0.25 it would be free.
    const bool unknown = grey == MapImage::kUnknown || (probability >= free && probability <= occupied);
    image.cells.push_back(unknown ? MapImage::kUnknown : probability < free ? MapImage::kFree : MapImage::kOccupied);
  }
  return image;
}

}  // namespace slam
