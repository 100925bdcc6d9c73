// SPDX-License-Identifier: BSD-3-Clause
#include "tools/slamctl/maps/map_drawing.hpp"

#include <cstdint>
#include <cstdio>
#include <cstring>

#include "tools/common/escaped.hpp"

namespace slam {
namespace {

constexpr double kPaper = 10.0;  // [mm] a metre: 1:100

/// The sheet that shows an image: y goes down.
class Sheet {
 public:
  explicit Sheet(const MapImage& image) : image_(image), top_(image.origin_y + image.height * image.resolution) {
    const double wide = kPaper * image.width * image.resolution, high = kPaper * image.height * image.resolution;
    text_ = "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"" + number(wide) + "mm\" height=\"" + number(high) +
            "mm\" viewBox=\"0 0 " + number(wide) + " " + number(high) + "\">\n";
  }

  void addWalls() {
    text_ += "<path class=\"walls\" fill=\"black\" d=\"";
    const std::string cell = number(kPaper * image_.resolution);
    for (int row = 0; row < image_.height; ++row) {
      for (int column = 0; column < image_.width; ++column) {
        const int first = column;
        while (column < image_.width && image_.at(column, row) == MapImage::kOccupied) ++column;
        if (column == first) continue;
        const std::string length = number(kPaper * image_.resolution * (column - first));
        const Eigen::Vector2d corner(image_.origin_x + first * image_.resolution,
                                     image_.origin_y + (row + 1) * image_.resolution);
        for (const std::string& part : {std::string("M"), place(corner), std::string("h"), length, std::string("v"),
                                        cell, std::string("h-"), length, std::string("z")})
          text_ += part;
      }
    }
    text_ += "\"/>\n";
  }
  void addLine(const char* style, std::span<const Eigen::Vector2d> points, bool closed) {
    text_ += std::string(closed ? "<polygon " : "<polyline ") + style + " points=\"";
    for (const Eigen::Vector2d& p : points) (text_ += place(p)) += ' ';
    text_ += "\"/>\n";
  }
  void addName(const Eigen::Vector2d& p, const std::string& name) {
    const std::string at = place(p);
    const auto comma = at.find(',');
    const std::string x = at.substr(0, comma), y = at.substr(comma + 1);
    for (const std::string& part :
         {std::string("<circle cx=\""), x, std::string("\" cy=\""), y, std::string("\" r=\"0.8\"/><text x=\""), x,
          std::string("\" y=\""), y, std::string("\" font-size=\"4\">"), escaped(name), std::string("</text>\n")})
      text_ += part;
  }
  std::string text() const { return text_ + "</svg>\n"; }

 private:
  static std::string number(double value) {
    char text[40];
    std::snprintf(text, sizeof text, "%.2f", value);
    return text;
  }
  std::string place(const Eigen::Vector2d& p) const {
    return number(kPaper * (p.x() - image_.origin_x)) + "," + number(kPaper * (top_ - p.y()));
  }

  const MapImage& image_;
  double top_;  // [m] in map
  std::string text_;
};

const char* styleOf(EditKind kind) {
  switch (kind) {
    case EditKind::kNoGo:
      return "class=\"no_go\" fill=\"red\" fill-opacity=\"0.3\" stroke=\"red\" stroke-width=\"0.3\"";
    case EditKind::kWall:
      return "class=\"wall\" fill=\"none\" stroke=\"red\" stroke-width=\"0.5\"";
    case EditKind::kRoom:
      return "class=\"room\" fill=\"green\" fill-opacity=\"0.15\" stroke=\"green\" stroke-width=\"0.3\"";
    default:
      return "class=\"outline\" fill=\"none\" stroke=\"grey\" stroke-width=\"0.3\"";
  }
}

}  // namespace

std::string mapSvg(const MapState& map, const MapImage& image, std::span<const Eigen::Vector2d> path) {
  Sheet sheet(image);
  sheet.addWalls();
  sheet.addLine("class=\"path\" fill=\"none\" stroke=\"blue\" stroke-width=\"0.2\"", path, false);
  for (const MapEdit& edit : map.edits.edits) {
    const Outline points = pointsOf(edit, map.keyframes, map.in_map);
    if (!edit.active || points.empty()) continue;
    if (points.size() > 1) sheet.addLine(styleOf(edit.kind), points, edit.kind != EditKind::kWall);
    Eigen::Vector2d middle = Eigen::Vector2d::Zero();
    for (const Eigen::Vector2d& p : points) middle += p / static_cast<double>(points.size());
    if (!edit.name.empty()) sheet.addName(middle, edit.name);
  }
  return sheet.text();
}

std::string pointsPly(const MapState& map) {
  std::string points;
  std::uint64_t count = 0;
  for (int id = 0; id < map.keyframes.size(); ++id) {
    if (map.in_map[static_cast<std::size_t>(id)] == 0) continue;
    const PointTransform T_map_base(map.keyframes.pose(id));
    for (const Keyframe::Point& point : map.keyframes.scan(id)->points) {
      const Eigen::Vector2d p = T_map_base * Eigen::Vector2d(point.x, point.y);
      for (const float value : {static_cast<float>(p.x()), static_cast<float>(p.y()), 0.0F}) {
        std::uint32_t bits = 0;
        std::memcpy(&bits, &value, sizeof bits);
        for (int shift = 0; shift < 32; shift += 8) points += static_cast<char>(bits >> shift & 0xFF);
      }
      ++count;
    }
  }
  return "ply\nformat binary_little_endian 1.0\ncomment metres in map\nelement vertex " + std::to_string(count) +
         "\nproperty float x\nproperty float y\nproperty float z\nend_header\n" + points;
}

}  // namespace slam
