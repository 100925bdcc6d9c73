// SPDX-License-Identifier: BSD-3-Clause
#include "slam/edits/edit_json.hpp"

#include <nlohmann/json.hpp>
#include <stdexcept>

namespace slam {
namespace {

using Json = nlohmann::json;

double numberOf(const Json& value, const char* what) {
  if (!value.is_number()) throw std::runtime_error(std::string("an edit: ") + what + " is no number");
  return value.get<double>();
}

std::string textOf(const Json& value, const std::string& what) {
  if (!value.is_string()) throw std::runtime_error("an edit: " + what + " is no text");
  return value.get<std::string>();
}

Outline pointsIn(const Json& list) {
  Outline points;
  if (!list.is_array()) throw std::runtime_error("an edit: points is no list of [x, y]");
  for (const Json& point : list) {
    if (!point.is_array() || point.size() != 2) throw std::runtime_error("an edit: a point is no [x, y]");
    points.emplace_back(numberOf(point[0], "x"), numberOf(point[1], "y"));
  }
  return points;
}

}  // namespace

EditRequest editRequestOf(std::string_view json) {
  const Json edit = Json::parse(json, nullptr, false);
  if (!edit.is_object()) throw std::runtime_error("an edit is no JSON object; docs/api.md shows one");
  EditRequest request;
  bool has_kind = false;
  for (const auto& [key, value] : edit.items()) {
    if (key == "kind") {
      const auto kind = editKindOf(textOf(value, key));
      if (!kind) throw std::runtime_error("an edit's kind is erase, free, wall, zone, room or place");
      request.kind = *kind;
      has_kind = true;
    } else if (key == "name") {
      request.name = textOf(value, key);
    } else if (key == "by") {
      request.author = textOf(value, key);
    } else if (key == "points") {
      request.points = pointsIn(value);
    } else if (key == "theta") {
      request.theta = numberOf(value, "theta");
    } else if (key == "sigma") {
      if (!value.is_array() || value.size() != 3) throw std::runtime_error("an edit: sigma is no [x, y, theta]");
      for (int i = 0; i < 3; ++i) request.sigma[i] = numberOf(value[static_cast<std::size_t>(i)], "sigma");
    } else if (key == "force") {
      if (!value.is_boolean()) throw std::runtime_error("an edit: force is neither true nor false");
      request.force = value.get<bool>();
    } else {
      throw std::runtime_error("an edit: nothing is called " + Json(key).dump() +
                               "; it has kind, points, name, by, theta, sigma and force");
    }
  }
  if (!has_kind) throw std::runtime_error("an edit's kind is missing");
  return request;
}

Json propertiesOf(const MapEdit& edit, const KeyframeGraph& keyframes) {
  Json one = {{"id", edit.id}, {"kind", nameOf(edit.kind)}, {"by", edit.author}, {"utime", edit.utime}};
  if (!edit.name.empty()) one["name"] = edit.name;
  if (edit.kind == EditKind::kPlace) {
    one["theta"] = poseOf(edit, keyframes).theta;
    one["sigma"] = {edit.sigma.x(), edit.sigma.y(), edit.sigma.z()};
  }
  return one;
}

Json listOf(const Outline& points) {
  Json list = Json::array();
  for (const Eigen::Vector2d& p : points) list.push_back({p.x(), p.y()});
  return list;
}

std::string editsJson(const MapEdits& edits, const KeyframeGraph& keyframes, std::span<const char> in_map) {
  Json list = Json::array();
  for (const MapEdit& edit : edits.edits) {
    const Outline points = pointsOf(edit, keyframes, in_map);
    if (!edit.active || points.empty()) continue;
    list.push_back(propertiesOf(edit, keyframes));
    list.back()["points"] = listOf(points);
  }
  return list.dump(-1, ' ', false, Json::error_handler_t::replace);
}

}  // namespace slam
