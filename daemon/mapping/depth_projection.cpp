// SPDX-License-Identifier: BSD-3-Clause
#include "mapping/depth_projection.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <stdexcept>

namespace slam {
namespace {

constexpr int kBands = 32;                  // groups of rows
constexpr double kSlot = 0.05;              // [m] of range
constexpr std::uint16_t kFarthest = 10000;  // [mm] of the 1 mm format; what is more is no depth
constexpr double kMinValid = 0.5;           // [1] share of a band's pixels with depth: the others are dropouts
constexpr double kPointsPerPixel = 8.0 / (640 * 480);  // of an obstacle: fewer are flying pixels
constexpr int kFewestPoints = 3;
constexpr double kSigma = 2.9e-3;      // [1/m] times depth squared: a step of the depth's quantisation
constexpr int kPeak = 4;               // a slot with so many times the points is the wall, the other its noise
constexpr double kFewestValid = 0.02;  // [1] share of all pixels with depth
constexpr double kMostBelow = 0.15;    // [1] share of the floor's points that lie below it: no stairs are so wide
constexpr double kBelow = 0.10;        // [m] under the floor
constexpr int kThinning = 8;           // every so many pixels, in row and column, serve to find the floor

/// 0 is no depth: of two that are left the farther one, of one nothing.
std::uint16_t medianOf(std::uint16_t a, std::uint16_t b, std::uint16_t c) {
  const int missing = (a == 0) + (b == 0) + (c == 0);
  if (missing > 0) return missing > 1 ? std::uint16_t{0} : std::max({a, b, c});
  return std::max(std::min(a, b), std::min(std::max(a, b), c));
}

}  // namespace

const char* describe(DepthStatus status) {
  switch (status) {
    case DepthStatus::kOk:
      return "";
    case DepthStatus::kWrongSize:
      return "images of a wrong size are not used";
    case DepthStatus::kNoDepth:
      return "images without depth are not used: is the camera covered, or blinded by the sun?";
    case DepthStatus::kTilted:
      return "images are not used, the floor is not where [depth] puts it: check pitch, roll and z";
    case DepthStatus::kBelowFloor:
      return "images are not used, they show much below the floor: check pitch, roll and z";
  }
  return "";
}

DepthProjection::DepthProjection(const DepthProjectionConfig& config)
    : config_(config), floor_(config.floor), slots_(static_cast<int>(std::ceil(config.range_max / kSlot)) + 1) {
  if (!(config.extrinsics.z > config.floor_clearance)) {
    throw std::invalid_argument("the depth camera's height above the floor is not given");
  }
  if (!(config.bearing_step > 0.0) || !(config.robot_height > config.floor_clearance)) {
    throw std::invalid_argument("the depth projection has no beams or no height band");
  }
}

void DepthProjection::prepare(const DepthIntrinsics& intrinsics) {
  intrinsics_ = intrinsics;
  const Eigen::Matrix3d level = (Eigen::AngleAxisd(config_.extrinsics.pitch, Eigen::Vector3d::UnitY()) *
                                 Eigen::AngleAxisd(config_.extrinsics.roll, Eigen::Vector3d::UnitX()))
                                    .toRotationMatrix();
  const auto ray = [&](int u, int v) -> Eigen::Vector3d {
    return level * Eigen::Vector3d(1.0, (intrinsics.cx - u) / intrinsics.fx, (intrinsics.cy - v) / intrinsics.fy);
  };
  const auto bearing = [](const Eigen::Vector3d& r) { return std::atan2(r.y(), r.x()); };
  double left = -std::numbers::pi, right = std::numbers::pi;
  for (const int u : {0, intrinsics.width - 1}) {
    for (const int v : {0, intrinsics.height / 2, intrinsics.height - 1}) {
      left = std::max(left, bearing(ray(u, v)));
      right = std::min(right, bearing(ray(u, v)));
    }
  }
  const int beams = std::min(PseudoLaser::kCapacity, static_cast<int>((left - right) / config_.bearing_step) + 1);
  laser_.size = beams;
  laser_.bearing_step = static_cast<float>((left - right) / beams);
  laser_.bearing_min = static_cast<float>(right + 0.5 * (left - right) / beams);
  beam_cos_.resize(static_cast<std::size_t>(beams));
  beam_sin_.resize(static_cast<std::size_t>(beams));
  lift_.assign(static_cast<std::size_t>(beams), 0.0F);
  for (std::size_t beam = 0; beam < beam_cos_.size(); ++beam) {
    const float direction = laser_.bearing_min + static_cast<float>(beam) * laser_.bearing_step;
    beam_cos_[beam] = std::cos(direction);
    beam_sin_[beam] = std::sin(direction);
  }
  slot_of_.resize(static_cast<std::size_t>(beams) * static_cast<std::size_t>(slots_));
  band_of_.assign(static_cast<std::size_t>(beams) * kBands, {});
  pixels_.resize(intrinsics.pixels());
  for (int v = 0; v < intrinsics.height; ++v) {
    for (int u = 0; u < intrinsics.width; ++u) {
      const Eigen::Vector3d r = ray(u, v);
      const auto beam = static_cast<std::size_t>(
          std::clamp(static_cast<int>((bearing(r) - right) / (left - right) * beams), 0, beams - 1));
      const double across = r.head<2>().norm();
      pixels_[static_cast<std::size_t>(v * intrinsics.width + u)] = {
          static_cast<float>(across), static_cast<float>(r.z()), static_cast<std::uint16_t>(beam)};
      Band& band = band_of_[beam * kBands + static_cast<std::size_t>(v * kBands / intrinsics.height)];
      const auto slope = static_cast<float>(r.z() / across);
      band.slope_low = band.pixels == 0 ? slope : std::min(band.slope_low, slope);
      band.slope_high = band.pixels == 0 ? slope : std::max(band.slope_high, slope);
      ++band.pixels;
    }
  }
  min_points_ = std::max(kFewestPoints, static_cast<int>(kPointsPerPixel * static_cast<double>(intrinsics.pixels())));
  points_.reserve(intrinsics.pixels() / (kThinning * kThinning) + 1);
  older_.clear();
  oldest_.clear();
  median_.resize(config_.median == 3 ? intrinsics.pixels() : 0);
}

DepthProjection::Status DepthProjection::project(const DepthImage& image) {
  const DepthIntrinsics& intrinsics = image.intrinsics;
  const bool camera = intrinsics.width > 0 && intrinsics.height > 0 && intrinsics.fx > 0.0 && intrinsics.fy > 0.0;
  if (!camera || image.depth.size() != intrinsics.pixels()) return Status::kWrongSize;
  if (!(intrinsics == intrinsics_)) prepare(intrinsics);
  laser_.stamp = image.stamp;
  const std::vector<std::uint16_t>& depth = smoothed(image.depth);
  if (const Status status = trackFloor(image, depth); status != Status::kOk) return status;
  sortPixels(depth);
  laser_.surface_count = 0;
  for (int beam = 0; beam < laser_.size; ++beam) {
    const int slot = firstObstacle(beam);
    const double covered_from = coveredFrom(beam);
    laser_.storage[static_cast<std::size_t>(beam)] =
        slot >= 0 ? hitAt(beam, slot, covered_from) : freeOf(beam, covered_from);
    if (slot >= 0) addSurfaces(beam, slot);
  }
  return Status::kOk;
}

const std::vector<std::uint16_t>& DepthProjection::smoothed(const std::vector<std::uint16_t>& depth) {
  if (config_.median != 3) return depth;
  const bool enough = oldest_.size() == depth.size() && older_.size() == depth.size();
  if (enough) {
    for (std::size_t i = 0; i < depth.size(); ++i) median_[i] = medianOf(depth[i], older_[i], oldest_[i]);
  }
  oldest_.swap(older_);
  older_ = depth;
  return enough ? median_ : depth;
}

DepthProjection::Status DepthProjection::trackFloor(const DepthImage& image, const std::vector<std::uint16_t>& depth) {
  const auto width = static_cast<std::size_t>(intrinsics_.width), height = static_cast<std::size_t>(intrinsics_.height);
  const auto nearest = static_cast<std::uint16_t>(1e3 * config_.range_min);
  const auto camera_height = static_cast<float>(config_.extrinsics.z);
  std::size_t looked = 0, low = 0, below = 0;
  points_.clear();
  for (std::size_t v = kThinning / 2; v < height; v += kThinning) {
    for (std::size_t u = kThinning / 2; u < width; u += kThinning) {
      ++looked;
      const std::uint16_t d = depth[v * width + u];
      if (d < nearest || d > kFarthest) continue;
      const Pixel& pixel = pixels_[v * width + u];
      const float z = 1e-3F * static_cast<float>(d), range = z * pixel.across;
      const float lift = static_cast<float>(floor_.plane().offset) + range * lift_[pixel.beam];
      const float h = camera_height + z * pixel.up;
      low += pixel.up < -0.1F;
      below += h - lift < -static_cast<float>(kBelow) - 0.03F * range;
      if (range > config_.range_max) continue;
      points_.emplace_back(range * beam_cos_[pixel.beam], range * beam_sin_[pixel.beam], h);
    }
  }
  const std::size_t valid = points_.size();
  if (static_cast<double>(valid) < kFewestValid * static_cast<double>(looked)) {
    // Far walls alone are no fault, if they are seen at all.
    if (low == 0 || valid == 0) return Status::kNoDepth;
  }
  const auto tilt = floor_.update(image.stamp, points_, camera_height);
  if (tilt) {
    tilt_ = *tilt;
    return Status::kTilted;
  }
  if (static_cast<double>(below) > kMostBelow * static_cast<double>(std::max<std::size_t>(low, 1))) {
    return Status::kBelowFloor;
  }
  const FloorPlane& plane = floor_.plane();
  for (std::size_t beam = 0; beam < lift_.size(); ++beam) {
    lift_[beam] = static_cast<float>(plane.slope_x * beam_cos_[beam] + plane.slope_y * beam_sin_[beam]);
  }
  return Status::kOk;
}

void DepthProjection::sortPixels(const std::vector<std::uint16_t>& depth) {
  std::fill(slot_of_.begin(), slot_of_.end(), Slot{});
  for (Band& band : band_of_) band.valid = 0;
  const auto nearest = static_cast<std::uint16_t>(1e3 * config_.range_min);
  const auto camera_height = static_cast<float>(config_.extrinsics.z - floor_.plane().offset);
  const auto low = static_cast<float>(config_.floor_clearance), high = static_cast<float>(config_.robot_height);
  const auto longest = static_cast<float>(config_.range_max);
  const auto width = static_cast<std::size_t>(intrinsics_.width);
  for (std::size_t v = 0, i = 0; v < static_cast<std::size_t>(intrinsics_.height); ++v) {
    Band* bands = &band_of_[v * kBands / static_cast<std::size_t>(intrinsics_.height)];
    for (std::size_t u = 0; u < width; ++u, ++i) {
      const std::uint16_t d = depth[i];
      if (d < nearest || d > kFarthest) continue;
      const Pixel& pixel = pixels_[i];
      const float z = 1e-3F * static_cast<float>(d), range = z * pixel.across;
      const float height = camera_height + z * pixel.up - range * lift_[pixel.beam];
      ++bands[pixel.beam * kBands].valid;
      if (height < low || height > high || range > longest) continue;
      Slot& slot = slot_of_[static_cast<std::size_t>(pixel.beam) * static_cast<std::size_t>(slots_) +
                            static_cast<std::size_t>(range * static_cast<float>(1.0 / kSlot))];
      ++slot.points;
      slot.sum += range;
    }
  }
}

/// Slot in which the nearest obstacle is seen best, or -1.
int DepthProjection::firstObstacle(int beam) const {
  const Slot* slots = &slot_of_[static_cast<std::size_t>(beam) * static_cast<std::size_t>(slots_)];
  for (int i = 0; i + 1 < slots_; ++i) {
    if (slots[i].points + slots[i + 1].points < min_points_) continue;
    // Noise puts the first few points before the surface: go on to where most are.
    const double range = kSlot * (i + 1);
    const int reach = i + 1 + static_cast<int>(std::ceil(2.0 * kSigma * range * range / kSlot));
    int best = i;
    for (int j = i + 1; j <= std::min(reach, slots_ - 1) && slots[j].points > slots[best].points; ++j) best = j;
    return best;
  }
  return -1;
}

/// [m] nearer than this not all heights are in view.
double DepthProjection::coveredFrom(int beam) const {
  const double z = config_.extrinsics.z - floor_.plane().offset;
  double lowest = 0.0, highest = 0.0;
  for (int i = 0; i < kBands; ++i) {
    const Band& band = band_of_[static_cast<std::size_t>(beam * kBands + i)];
    if (band.pixels == 0) continue;
    const double lift = lift_[static_cast<std::size_t>(beam)];
    lowest = std::min(lowest, band.slope_low - lift);
    highest = std::max(highest, band.slope_high - lift);
  }
  const double never = std::numeric_limits<double>::infinity();
  const double low = z - config_.floor_clearance, high = config_.robot_height - z;
  const double floor_from = lowest < 0.0 ? low / -lowest : never;
  const double top_from = high <= 0.0 ? 0.0 : highest > 0.0 ? high / highest : never;
  return std::max({config_.range_min, floor_from, top_from});
}

/// Whether a band has no depth, and the distances at which it looks between the floor and the robot's top.
bool DepthProjection::blindBetween(int beam, const Band& band, double* from, double* to) const {
  if (band.pixels == 0 || band.valid >= kMinValid * band.pixels) return false;
  const double z = config_.extrinsics.z - floor_.plane().offset, lift = lift_[static_cast<std::size_t>(beam)];
  const double low = band.slope_low - lift, high = band.slope_high - lift;
  // Its rays are between the two heights from the first to the last of the distances where a border ray crosses one.
  const double up = config_.robot_height - z, down = z - config_.floor_clearance;
  *from = up < 0.0 ? (low < 0.0 ? -up / -low : std::numeric_limits<double>::infinity()) : 0.0;
  *to = std::numeric_limits<double>::infinity();
  if (low > 0.0) *to = std::max(0.0, up / low);
  if (high < 0.0) *to = down / -high;
  return *from < *to;
}

PseudoBeam DepthProjection::hitAt(int beam, int slot, double covered_from) const {
  const Slot* slots = &slot_of_[static_cast<std::size_t>(beam) * static_cast<std::size_t>(slots_)];
  Slot around;
  for (int i = std::max(0, slot - 1); i <= std::min(slot + 1, slots_ - 1); ++i) {
    around.points += slots[i].points;
    around.sum += slots[i].sum;
  }
  const double range = around.sum / static_cast<float>(around.points);
  double free_from = covered_from;
  for (int i = 0; i < kBands; ++i) {
    double from, to;
    const Band& band = band_of_[static_cast<std::size_t>(beam * kBands + i)];
    if (blindBetween(beam, band, &from, &to) && from < range) free_from = std::max(free_from, to);
  }
  PseudoBeam result{.kind = PseudoBeam::Kind::kHit};
  result.range = static_cast<float>(range);
  result.free_from = static_cast<float>(std::min(free_from, range));
  return result;
}

/// What is seen of obstacles behind the nearest one: stretches of slots with points.
void DepthProjection::addSurfaces(int beam, int hit_slot) {
  for (int first = hit_slot + 1; first < slots_; ++first) {
    if (!isSurface(beam, first)) continue;
    int last = first;
    while (last + 1 < slots_ && (isSurface(beam, last + 1) || isSurface(beam, last + 2))) ++last;
    laser_.push({static_cast<std::uint16_t>(beam), static_cast<float>(kSlot * (first + 0.5)),
                 static_cast<float>(kSlot * (last + 0.5))});
    first = last;
  }
}

/// Whether a slot's points are those of a surface: its neighbours have some, too, as flying pixels do not, and they are
/// not the noise around a wall, of which most points lie in a slot near by.
bool DepthProjection::isSurface(int beam, int slot) const {
  const auto points = [&](int b, int s) {
    if (b < 0 || b >= laser_.size || s < 0 || s >= slots_) return 0;
    return slot_of_[static_cast<std::size_t>(b) * static_cast<std::size_t>(slots_) + static_cast<std::size_t>(s)]
        .points;
  };
  const int own = points(beam, slot);
  if (own == 0) return false;
  int around = 0;
  for (int b = beam - 1; b <= beam + 1; ++b) {
    for (int s = slot - 1; s <= slot + 1; ++s) around += points(b, s);
  }
  if (around < min_points_ + 1) return false;
  const double range = kSlot * (slot + 0.5);
  const int noise = 1 + static_cast<int>(std::ceil(2.0 * kSigma * range * range / kSlot));
  for (int s = slot - noise; s <= slot + noise; ++s) {
    if (points(beam, s) > kPeak * own) return false;
  }
  return true;
}

PseudoBeam DepthProjection::freeOf(int beam, double covered_from) const {
  double from = covered_from, to = config_.range_max;
  // Each blind band takes its distances away; what is left before the first that lies further out counts.
  for (bool moved = true; moved;) {
    moved = false;
    for (int i = 0; i < kBands; ++i) {
      double blind_from, blind_to;
      const Band& band = band_of_[static_cast<std::size_t>(beam * kBands + i)];
      if (!blindBetween(beam, band, &blind_from, &blind_to)) continue;
      if (blind_from <= from && blind_to > from) {
        from = blind_to;
        moved = true;
      }
    }
  }
  for (int i = 0; i < kBands; ++i) {
    double blind_from, blind_to;
    const Band& band = band_of_[static_cast<std::size_t>(beam * kBands + i)];
    if (blindBetween(beam, band, &blind_from, &blind_to) && blind_from > from) to = std::min(to, blind_from);
  }
  if (!(to - from > kSlot)) return {};
  PseudoBeam result{.kind = PseudoBeam::Kind::kFree};
  result.range = static_cast<float>(to);
  result.free_from = static_cast<float>(from);
  return result;
}

}  // namespace slam
