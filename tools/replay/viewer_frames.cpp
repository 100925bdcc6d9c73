// SPDX-License-Identifier: BSD-3-Clause
#include "tools/replay/viewer_frames.hpp"

#include <algorithm>
#include <array>
#include <cerrno>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <stdexcept>
#include <string>

#include "mapping/map_files.hpp"

namespace slam {
namespace {

namespace fs = std::filesystem;

constexpr double kMargin = 0.5;                     // [m] around map and robot
constexpr int kLongSide = 1400, kLargestScale = 8;  // [pixels] wanted of the picture, and at most of a cell
constexpr double kRobotLength = 0.5;                // [m] as drawn ...
constexpr double kLeastRobot = 18.0;                // [pixels] ... and at least
constexpr int kNumberDigits = 6;

/// A map copied into a rectangle that also holds `p` with a margin.
MapImage widened(const MapImage& map, const Eigen::Vector2d& p) {
  const auto beyond = [&](double metres) { return std::max(0, static_cast<int>(std::ceil(metres / map.resolution))); };
  const double right = map.origin_x + map.width * map.resolution, top = map.origin_y + map.height * map.resolution;
  const int add_left = beyond(std::max(map.origin_x - p.x(), 0.0) + kMargin);
  const int add_bottom = beyond(std::max(map.origin_y - p.y(), 0.0) + kMargin);
  MapImage wide = map;
  wide.width += add_left + beyond(std::max(p.x() - right, 0.0) + kMargin);
  wide.height += add_bottom + beyond(std::max(p.y() - top, 0.0) + kMargin);
  wide.origin_x -= add_left * map.resolution;
  wide.origin_y -= add_bottom * map.resolution;
  wide.cells.assign(static_cast<std::size_t>(wide.width) * static_cast<std::size_t>(wide.height), MapImage::kUnknown);
  for (int row = 0; row < map.height; ++row) {
    for (int column = 0; column < map.width; ++column) {
      wide.at(column + add_left, row + add_bottom) = map.at(column, row);
    }
  }
  return wide;
}

/// Draws in map coordinates.
class Pen {
 public:
  Pen(const MapImage& map, int scale, ColourImage& image)
      : origin_(map.origin_x, map.origin_y), pixels_per_metre_(scale / map.resolution), image_(image) {}

  /// [pixels] from the upper left corner
  Eigen::Vector2d toPixels(const Eigen::Vector2d& p_map) const {
    const Eigen::Vector2d p = pixels_per_metre_ * (p_map - origin_);
    return {p.x(), image_.height - p.y()};
  }
  void dot(const Eigen::Vector2d& p_map, int side, Rgb colour) { square(toPixels(p_map), side, colour); }
  void line(const Eigen::Vector2d& from_map, const Eigen::Vector2d& to_map, int side, Rgb colour) {
    const Eigen::Vector2d from = toPixels(from_map), step = toPixels(to_map) - from;
    const int steps = std::max(1, static_cast<int>(std::ceil(step.cwiseAbs().maxCoeff())));
    for (int i = 0; i <= steps; ++i) square(from + step * (static_cast<double>(i) / steps), side, colour);
  }
  /// An arrowhead with its middle at the pose.
  void arrow(const Pose2& pose, Rgb colour) {
    const double length = std::max(kRobotLength, kLeastRobot / pixels_per_metre_);
    const std::array<Eigen::Vector2d, 3> corners{toPixels(pose * Eigen::Vector2d(0.6 * length, 0.0)),
                                                 toPixels(pose * Eigen::Vector2d(-0.4 * length, 0.35 * length)),
                                                 toPixels(pose * Eigen::Vector2d(-0.4 * length, -0.35 * length))};
    Eigen::Vector2d low = corners[0], high = corners[0];
    for (const Eigen::Vector2d& corner : corners) {
      low = low.cwiseMin(corner);
      high = high.cwiseMax(corner);
    }
    for (int row = static_cast<int>(low.y()); row <= static_cast<int>(high.y()); ++row) {
      for (int column = static_cast<int>(low.x()); column <= static_cast<int>(high.x()); ++column) {
        if (contains(corners, {column + 0.5, row + 0.5})) image_.set(column, row, colour);
      }
    }
  }

 private:
  static bool contains(const std::array<Eigen::Vector2d, 3>& corners, const Eigen::Vector2d& p) {
    int left = 0, right = 0;
    for (std::size_t i = 0; i < 3; ++i) {
      const Eigen::Vector2d side = corners[(i + 1) % 3] - corners[i], to = p - corners[i];
      const double cross = side.x() * to.y() - side.y() * to.x();
      left += cross >= 0.0;
      right += cross <= 0.0;
    }
    return left == 3 || right == 3;
  }
  void square(const Eigen::Vector2d& middle, int side, Rgb colour) {
    const int column = static_cast<int>(std::floor(middle.x())) - side / 2;
    const int row = static_cast<int>(std::floor(middle.y())) - side / 2;
    for (int r = 0; r < side; ++r) {
      for (int c = 0; c < side; ++c) image_.set(column + c, row + r, colour);
    }
  }

  Eigen::Vector2d origin_;
  double pixels_per_metre_;
  ColourImage& image_;
};

std::string numbered(int frame) {
  char name[32];
  std::snprintf(name, sizeof name, "frame-%0*d.png", kNumberDigits, frame);
  return name;
}

bool isFrame(const std::string& name) {
  return name.size() == numbered(0).size() && name.starts_with("frame-") && name.ends_with(".png") &&
         std::all_of(name.begin() + 6, name.begin() + 6 + kNumberDigits, [](char c) { return c >= '0' && c <= '9'; });
}

}  // namespace

ColourImage drawScene(const MapImage& map, const ViewerScene& scene) {
  const MapImage wide = widened(map, scene.T_map_base.translation());
  const int scale = std::clamp(kLongSide / std::max(wide.width, wide.height), 1, kLargestScale);
  ColourImage image = colourMap(wide, scale);
  Pen pen(wide, scale, image);
  for (const Eigen::Vector2d& p : scene.scan) pen.dot(scene.T_map_base * p, 3, kScanColour);
  for (std::size_t i = 1; i < scene.keyframes.size(); ++i) {
    pen.line(scene.keyframes[i - 1].translation(), scene.keyframes[i].translation(), 2, kPathColour);
  }
  for (const Edge& edge : scene.edges) {
    if (edge.kind != EdgeKind::kLoopClosure || edge.revoked) continue;
    pen.line(scene.keyframes[static_cast<std::size_t>(edge.from)].translation(),
             scene.keyframes[static_cast<std::size_t>(edge.to)].translation(), 2, kClosureColour);
  }
  pen.arrow(scene.T_map_base, kRobotColour);
  return image;
}

ViewerFrames::ViewerFrames(const fs::path& folder, double period) : folder_(folder), period_(period) {
  std::error_code error;
  fs::create_directories(folder, error);
  if (error || !fs::is_directory(folder)) {
    throw std::runtime_error(folder.string() + ": cannot make this folder for frames" +
                             (error ? ": " + error.message() : std::string()));
  }
  for (const auto& entry : fs::directory_iterator(folder)) {
    if (isFrame(entry.path().filename().string())) fs::remove(entry.path(), error);
  }
  index_.open(folder / "index.csv");
  index_ << "frame,log_s,x,y,theta,keyframes,loop_closures\n";
  if (!index_.flush()) {
    throw std::runtime_error((folder / "index.csv").string() + ": cannot write: " + std::strerror(errno));
  }
}

void ViewerFrames::write(const MapImage& map, const ViewerScene& scene) {
  const std::string name = numbered(frames_++);
  replaceFile(folder_ / name, encodePng(drawScene(map, scene)));
  const auto closures = std::count_if(scene.edges.begin(), scene.edges.end(), [](const Edge& edge) {
    return edge.kind == EdgeKind::kLoopClosure && !edge.revoked;
  });
  char row[200];
  std::snprintf(row, sizeof row, "%s,%.3f,%.4f,%.4f,%.5f,%zu,%d\n", name.c_str(), scene.log_s, scene.T_map_base.x,
                scene.T_map_base.y, scene.T_map_base.theta, scene.keyframes.size(), static_cast<int>(closures));
  index_ << row;
  while (next_ <= scene.log_s) next_ += period_;
}

void ViewerFrames::close() {
  index_.close();
  if (!index_) throw std::runtime_error((folder_ / "index.csv").string() + ": cannot write all of it");
}

}  // namespace slam
