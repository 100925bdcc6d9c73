// SPDX-License-Identifier: BSD-3-Clause
#include "tools/sim/depth/depth_renderer.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

namespace slam::sim {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr double kNever = std::numeric_limits<double>::infinity();

/// Pixels [left, right) x [top, bottom).
struct Rectangle {
  int left, top, right, bottom;
};

/// Convex polygon of up to 4 corners, clipped to one plane.
struct Polygon {
  std::array<Vector3d, 8> corners;
  int size = 0;

  void push(const Vector3d& corner) { corners[static_cast<std::size_t>(size++)] = corner; }
};

/// The corners of a box: bit 0 along its yaw, bit 1 across, bit 2 up.
using Corners = std::array<Vector3d, 8>;

class Canvas {
 public:
  Canvas(const DepthIntrinsics& intrinsics, const Eigen::Isometry3d& T_world_camera, std::span<float> inverse_depth)
      : k_(intrinsics),
        T_world_camera_(T_world_camera),
        T_camera_world_(T_world_camera.inverse()),
        out_(inverse_depth) {}

  void drawFloorAndCeiling();
  void draw(const Box& box);
  void draw(const Cylinder& cylinder);
  void draw(const Sphere& sphere);

 private:
  /// 1/Z = at_origin + per_column u + per_row v, equation (1).
  struct Plane {
    double at_origin, per_column, per_row;
  };

  float* row(int v) { return out_.data() + static_cast<std::ptrdiff_t>(v) * k_.width; }
  Vector2d project(const Vector3d& p) const { return {k_.cx + k_.fx * p.x() / p.z(), k_.cy + k_.fy * p.y() / p.z()}; }
  Vector3d ray(int u, int v) const { return {(u - k_.cx) / k_.fx, (v - k_.cy) / k_.fy, 1.0}; }
  Plane planeThrough(const Vector3d& normal, double distance) const;
  void fill(const Polygon& polygon, const Plane& plane);
  void fillRow(int v, double left, double right, const Plane& plane);
  Rectangle around(const Corners& corners) const;
  Corners cornersOf(const Box& box) const;

  const DepthIntrinsics& k_;
  Eigen::Isometry3d T_world_camera_, T_camera_world_;
  std::span<float> out_;
};

Canvas::Plane Canvas::planeThrough(const Vector3d& normal, double distance) const {
  const Vector3d n = normal / distance;
  const double per_column = n.x() / k_.fx, per_row = n.y() / k_.fy;
  return {n.z() - per_column * k_.cx - per_row * k_.cy, per_column, per_row};
}

void Canvas::fillRow(int v, double left, double right, const Plane& plane) {
  const int first = std::max(0, static_cast<int>(std::ceil(std::max(left, -1.0))));
  const int last = std::min(k_.width - 1, static_cast<int>(std::floor(std::min(right, k_.width + 1.0))));
  const auto start = static_cast<float>(plane.at_origin + plane.per_row * v);
  const auto slope = static_cast<float>(plane.per_column);
  float* const pixels = row(v);
  for (int u = first; u <= last; ++u) {
    const float inverse = start + slope * static_cast<float>(u);
    pixels[u] = inverse > pixels[u] ? inverse : pixels[u];
  }
}

void Canvas::drawFloorAndCeiling() {
  std::fill(out_.begin(), out_.end(), 0.0F);
  const Vector3d up = T_camera_world_.linear().col(2);
  const double height = T_world_camera_.translation().z();
  const Plane floor = planeThrough(up, -height), ceiling = planeThrough(up, World::kCeiling - height);
  for (int v = 0; v < k_.height; ++v) {
    fillRow(v, 0.0, k_.width - 1.0, floor);
    fillRow(v, 0.0, k_.width - 1.0, ceiling);
  }
}

/// The part of a polygon in front of the near plane (Sutherland and Hodgman).
Polygon clipNear(const Polygon& polygon) {
  Polygon clipped;
  for (int i = 0; i < polygon.size; ++i) {
    const Vector3d& a = polygon.corners[static_cast<std::size_t>(i)];
    const Vector3d& b = polygon.corners[static_cast<std::size_t>((i + 1) % polygon.size)];
    const double za = a.z() - DepthRenderer::kNear, zb = b.z() - DepthRenderer::kNear;
    if (za >= 0.0) clipped.push(a);
    if ((za >= 0.0) != (zb >= 0.0)) clipped.push(a + za / (za - zb) * (b - a));
  }
  return clipped;
}

void Canvas::fill(const Polygon& polygon, const Plane& plane) {
  const Polygon visible = clipNear(polygon);
  if (visible.size < 3) return;
  std::array<Vector2d, 8> corners;
  double top = kNever, bottom = -kNever;
  const auto size = static_cast<std::size_t>(visible.size);
  for (std::size_t i = 0; i < size; ++i) {
    corners[i] = project(visible.corners[i]);
    top = std::min(top, corners[i].y());
    bottom = std::max(bottom, corners[i].y());
  }
  const int first = static_cast<int>(std::ceil(std::max(top, 0.0)));
  const int last = static_cast<int>(std::floor(std::min(bottom, k_.height - 1.0)));
  for (int v = first; v <= last; ++v) {
    double left = kNever, right = -kNever;
    for (std::size_t i = 0; i < size; ++i) {
      const Vector2d &a = corners[i], &b = corners[(i + 1) % size];
      if (std::min(a.y(), b.y()) > v || std::max(a.y(), b.y()) < v) continue;
      const double u = a.y() == b.y() ? a.x() : a.x() + (v - a.y()) / (b.y() - a.y()) * (b.x() - a.x());
      left = std::min(left, u);
      right = std::max(right, u);
      if (a.y() == b.y()) right = std::max(right, b.x()), left = std::min(left, b.x());
    }
    fillRow(v, left, right, plane);
  }
}

Corners Canvas::cornersOf(const Box& box) const {
  const double c = std::cos(box.yaw), s = std::sin(box.yaw);
  Corners corners;
  for (unsigned i = 0; i < corners.size(); ++i) {
    const double along = (i & 1U ? 0.5 : -0.5) * box.length, across = (i & 2U ? 0.5 : -0.5) * box.width;
    corners[i] = T_camera_world_ * Vector3d(box.x + c * along - s * across, box.y + s * along + c * across,
                                            i & 4U ? box.top : box.bottom);
  }
  return corners;
}

void Canvas::draw(const Box& box) {
  static constexpr std::size_t kFaces[6][4] = {{0, 2, 6, 4}, {1, 3, 7, 5}, {0, 1, 5, 4},
                                               {2, 3, 7, 6}, {0, 1, 3, 2}, {4, 5, 7, 6}};
  const Corners corners = cornersOf(box);
  if (std::all_of(corners.begin(), corners.end(), [](const Vector3d& p) { return p.z() < DepthRenderer::kNear; })) {
    return;
  }
  const Vector3d middle = 0.5 * (corners[0] + corners[7]);
  for (const auto& face : kFaces) {
    Polygon polygon;
    for (const std::size_t i : face) polygon.push(corners[i]);
    Vector3d outward = 0.5 * (corners[face[0]] + corners[face[2]]) - middle;
    if (outward.squaredNorm() < 1e-18) continue;
    outward.normalize();
    const double distance = outward.dot(corners[face[0]]);
    if (distance < -1e-6) fill(polygon, planeThrough(outward, distance));  // else seen from behind
  }
}

/// The rectangle that a convex hull of corners covers on the screen.
Rectangle Canvas::around(const Corners& corners) const {
  Vector2d low = Vector2d::Constant(kNever), high = -low;
  const auto include = [&](const Vector3d& p) {
    low = low.cwiseMin(project(p));
    high = high.cwiseMax(project(p));
  };
  for (unsigned i = 0; i < corners.size(); ++i) {
    const double zi = corners[i].z() - DepthRenderer::kNear;
    if (zi >= 0.0) include(corners[i]);
    for (const unsigned bit : {1U, 2U, 4U}) {
      const double zj = corners[i ^ bit].z() - DepthRenderer::kNear;
      if (zi >= 0.0 && zj < 0.0) include(corners[i] + zi / (zi - zj) * (corners[i ^ bit] - corners[i]));
    }
  }
  const auto clamped = [](double value, int limit) {
    return static_cast<int>(std::clamp(value, 0.0, static_cast<double>(limit)));
  };
  if (!(low.x() <= high.x())) return {0, 0, 0, 0};
  return {clamped(std::ceil(low.x()), k_.width), clamped(std::ceil(low.y()), k_.height),
          clamped(std::floor(high.x()) + 1.0, k_.width), clamped(std::floor(high.y()) + 1.0, k_.height)};
}

void Canvas::draw(const Cylinder& cylinder) {
  const double size = 2.0 * cylinder.radius;
  const Rectangle area = around(cornersOf({cylinder.x, cylinder.y, 0.0, size, size, cylinder.bottom, cylinder.top}));
  const Vector3d eye = T_world_camera_.translation();
  const Vector2d o(eye.x() - cylinder.x, eye.y() - cylinder.y);
  const double oo = o.squaredNorm() - cylinder.radius * cylinder.radius;
  const Vector3d step = T_world_camera_.linear().col(0) / k_.fx;  // of the ray, from column to column
  for (int v = area.top; v < area.bottom; ++v) {
    float* const pixels = row(v);
    const Vector3d first = T_world_camera_.linear() * ray(0, v);
    for (int u = area.left; u < area.right; ++u) {
      const double dx = first.x() + u * step.x(), dy = first.y() + u * step.y(), dz = first.z() + u * step.z();
      const double dd = dx * dx + dy * dy, od = o.x() * dx + o.y() * dy, discriminant = od * od - dd * oo;
      if (discriminant < 0.0 || dd < 1e-12) continue;
      const double root = std::sqrt(discriminant);
      double enter = (-od - root) / dd, leave = (-od + root) / dd;
      if (std::abs(dz) > 1e-12) {
        const double a = (cylinder.bottom - eye.z()) / dz, b = (cylinder.top - eye.z()) / dz;
        enter = std::max(enter, std::min(a, b));
        leave = std::min(leave, std::max(a, b));
      } else if (eye.z() < cylinder.bottom || eye.z() > cylinder.top) {
        continue;
      }
      if (enter < DepthRenderer::kNear || enter > leave) continue;
      pixels[u] = std::max(pixels[u], static_cast<float>(1.0 / enter));
    }
  }
}

void Canvas::draw(const Sphere& sphere) {
  const double r = sphere.radius;
  const Rectangle area = around(cornersOf({sphere.x, sphere.y, 0.0, 2.0 * r, 2.0 * r, sphere.z - r, sphere.z + r}));
  const Vector3d centre = T_camera_world_ * Vector3d(sphere.x, sphere.y, sphere.z);
  const double cc = centre.squaredNorm() - r * r;
  for (int v = area.top; v < area.bottom; ++v) {
    float* const pixels = row(v);
    for (int u = area.left; u < area.right; ++u) {
      const Vector3d d = ray(u, v);
      const double dd = d.squaredNorm(), dc = d.dot(centre), discriminant = dc * dc - dd * cc;
      if (discriminant < 0.0) continue;
      const double depth = (dc - std::sqrt(discriminant)) / dd;
      if (depth >= DepthRenderer::kNear) pixels[u] = std::max(pixels[u], static_cast<float>(1.0 / depth));
    }
  }
}

}  // namespace

void DepthRenderer::render(const World& world, const Eigen::Isometry3d& T_world_camera,
                           std::span<float> inverse_depth) const {
  Canvas canvas(intrinsics_, T_world_camera, inverse_depth);
  canvas.drawFloorAndCeiling();
  for (const Solids* solids : {&world.still(), &world.moving()}) {
    for (const Box& box : solids->boxes) canvas.draw(box);
    for (const Cylinder& cylinder : solids->cylinders) canvas.draw(cylinder);
    for (const Sphere& sphere : solids->spheres) canvas.draw(sphere);
  }
}

}  // namespace slam::sim
