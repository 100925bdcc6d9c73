// SPDX-License-Identifier: BSD-3-Clause
#include "mapping/map_description.hpp"

#include <charconv>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <yaml-cpp/yaml.h>

namespace slam {
namespace {

[[noreturn]] void refuse(const std::string& what) { throw std::runtime_error(what); }

/// The value as it is written, for an error.
std::string textOf(const YAML::Node& value) {
  return value.IsScalar() ? "'" + value.Scalar() + "'" : value.IsNull() ? "nothing" : "a list or map";
}

double numberOf(const YAML::Node& value, const std::string& key) {
  double number = 0.0;
  if (!value.IsScalar() || !YAML::convert<double>::decode(value, number))
    refuse(key + ": " + textOf(value) + " is not a number");
  if (!std::isfinite(number)) refuse(key + ": " + textOf(value) + " is no finite number");
  return number;
}

double thresholdOf(const YAML::Node& map, const char* key, double otherwise) {
  const YAML::Node value = map[key];
  if (!value.IsDefined()) return otherwise;
  const double threshold = numberOf(value, key);
  if (!(threshold >= 0.0 && threshold <= 1.0)) refuse(std::string(key) + ": " + textOf(value) + " is not from 0 to 1");
  return threshold;
}

YAML::Node required(const YAML::Node& map, const char* key) {
  YAML::Node value = map[key];
  if (!value.IsDefined()) refuse("has no key '" + std::string(key) + "', which a map_server file needs");
  return value;
}

Pose2 originOf(const YAML::Node& origin) {
  if (!origin.IsSequence() || origin.size() != 3) refuse("origin is not a list of three numbers, [x, y, yaw]");
  return {numberOf(origin[0], "origin"), numberOf(origin[1], "origin"), numberOf(origin[2], "origin")};
}

MapDescription::Mode modeOf(const YAML::Node& value) {
  using Mode = MapDescription::Mode;
  if (!value.IsDefined()) return Mode::kTrinary;
  for (const auto& [name, mode] :
       {std::pair("trinary", Mode::kTrinary), {"scale", Mode::kScale}, {"raw", Mode::kRaw}}) {
    if (value.IsScalar() && value.Scalar() == name) return mode;
  }
  refuse("mode: " + textOf(value) + " is not trinary, scale or raw");
}

bool negateOf(const YAML::Node& value) {
  if (!value.IsDefined()) return false;
  bool flag = false;
  if (value.IsScalar() && (value.Scalar() == "0" || value.Scalar() == "1")) return value.Scalar() == "1";
  if (!value.IsScalar() || !YAML::convert<bool>::decode(value, flag))
    refuse("negate: " + textOf(value) + " is not 0, 1, false or true");
  return flag;
}

/// As few digits as read back as the number; what a product of decimal fractions is off by, as 3 * 0.1, is no digit.
std::string shortest(double number) {
  const double decimal = std::round(number * 1e9) / 1e9;
  if (std::abs(decimal - number) <= std::numeric_limits<double>::epsilon() * std::abs(number)) number = decimal;
  if (number == 0.0) number = 0.0;  // not -0
  char digits[32];
  return {digits, std::to_chars(digits, digits + sizeof digits, number).ptr};
}

}  // namespace

MapDescription parseMapDescription(const std::string& yaml) {
  try {
    const YAML::Node map = YAML::Load(yaml);
    if (!map.IsMap()) refuse("holds no keys with values, as a map_server file does");
    MapDescription description;
    const YAML::Node image = required(map, "image");
    if (!image.IsScalar() || image.Scalar().empty()) refuse("image: " + textOf(image) + " is no name of a picture");
    description.image = image.Scalar();
    description.resolution = numberOf(required(map, "resolution"), "resolution");
    description.T_map_picture = originOf(required(map, "origin"));
    description.mode = modeOf(map["mode"]);
    description.negate = negateOf(map["negate"]);
    description.occupied_threshold = thresholdOf(map, "occupied_thresh", description.occupied_threshold);
    description.free_threshold = thresholdOf(map, "free_thresh", description.free_threshold);
    if (description.free_threshold > description.occupied_threshold) refuse("free_thresh is above occupied_thresh");
    return description;
  } catch (const YAML::Exception& error) {
    refuse("line " + std::to_string(error.mark.line + 1) + " is no YAML: " + error.msg);
  }
}

std::array<std::uint8_t, 256> cellsOfGreys(const MapDescription& description) {
  using Mode = MapDescription::Mode;
  const double occupied = description.occupied_threshold, free = description.free_threshold;
  const auto cellOf = [&](int grey) -> std::uint8_t {
    if (description.mode == Mode::kRaw) return grey > 100 ? MapImage::kUnknown : classify(grey / 100.0);
    // 205 means unknown whatever the thresholds: with map_server's own of 0.25 it would be free.
    const bool trinary = description.mode == Mode::kTrinary;
    if (trinary && !description.negate && grey == MapImage::kUnknown) return MapImage::kUnknown;
    const double probability = (description.negate ? grey : 255 - grey) / 255.0;
    if (probability > occupied) return MapImage::kOccupied;
    if (probability < free) return MapImage::kFree;
    return trinary ? MapImage::kUnknown : classify((probability - free) / (occupied - free));
  };
  std::array<std::uint8_t, 256> cells{};
  for (int grey = 0; grey < 256; ++grey) cells[static_cast<std::size_t>(grey)] = cellOf(grey);
  return cells;
}

std::string encodeYaml(const std::string& picture, const MapImage& image) {
  return "image: " + picture + "\nmode: trinary\nresolution: " + shortest(image.resolution) + "\norigin: [" +
         shortest(image.origin_x) + ", " + shortest(image.origin_y) +
         ", 0]\nnegate: 0\noccupied_thresh: " + shortest(MapImage::kOccupiedThreshold) +
         "\nfree_thresh: " + shortest(MapImage::kFreeThreshold) + "\n";
}

}  // namespace slam
