// SPDX-License-Identifier: BSD-3-Clause
#include "slam/edits/edit_export.hpp"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "slam/edits/edit_json.hpp"

namespace slam {
namespace {

using Json = nlohmann::json;

/// Marks the cells of an image that a zone covers, or a line touches.
void mark(MapImage& mask, const Outline& points, bool zone) {
  const double half = 0.5 * mask.resolution;
  const Bounds bounds = Bounds::of(points).grown(half);
  const auto cell = [&](double p, double origin, int count) {
    return static_cast<int>(std::clamp(std::floor((p - origin) / mask.resolution), 0.0, count - 1.0));
  };
  for (int row = cell(bounds.low.y(), mask.origin_y, mask.height);
       row <= cell(bounds.high.y(), mask.origin_y, mask.height); ++row) {
    for (int column = cell(bounds.low.x(), mask.origin_x, mask.width);
         column <= cell(bounds.high.x(), mask.origin_x, mask.width); ++column) {
      const Eigen::Vector2d centre(mask.origin_x + (column + 0.5) * mask.resolution,
                                   mask.origin_y + (row + 0.5) * mask.resolution);
      if ((zone && holds(points, centre)) || touches(points, zone, centre, half))
        mask.at(column, row) = MapImage::kOccupied;
    }
  }
}

Json geometryOf(const MapEdit& edit, Outline points) {
  if (points.size() == 1) return {{"type", "Point"}, {"coordinates", {points[0].x(), points[0].y()}}};
  if (edit.kind == EditKind::kWall) return {{"type", "LineString"}, {"coordinates", listOf(points)}};
  double area = 0.0;  // twice; a ring of GeoJSON goes counterclockwise and ends where it began
  for (std::size_t i = 0, before = points.size() - 1; i < points.size(); before = i++)
    area += points[before].x() * points[i].y() - points[i].x() * points[before].y();
  if (area < 0.0) std::reverse(points.begin(), points.end());
  points.push_back(points.front());
  Json rings = Json::array();
  rings.push_back(listOf(points));
  return {{"type", "Polygon"}, {"coordinates", rings}};
}

}  // namespace

MapImage keepOutMask(const MapState& map, const MapImage& image) {
  MapImage mask = image;
  std::fill(mask.cells.begin(), mask.cells.end(), MapImage::kFree);
  for (const MapEdit& edit : map.edits.edits) {
    const bool zone = edit.kind == EditKind::kNoGo;
    if (!edit.active || (!zone && edit.kind != EditKind::kWall)) continue;
    const Outline points = pointsOf(edit, map.keyframes, map.in_map);
    if (!points.empty()) mark(mask, points, zone);
  }
  return mask;
}

std::string editsGeoJson(const MapState& map) {
  Json features = Json::array();
  for (const MapEdit& edit : map.edits.edits) {
    const Outline points = pointsOf(edit, map.keyframes, map.in_map);
    if (!edit.active || points.empty()) continue;
    features.push_back({{"type", "Feature"},
                        {"properties", propertiesOf(edit, map.keyframes)},
                        {"geometry", geometryOf(edit, points)}});
  }
  const Json all = {{"type", "FeatureCollection"}, {"features", features}};
  return all.dump(1, ' ', false, Json::error_handler_t::replace) + "\n";
}

}  // namespace slam
