// SPDX-License-Identifier: BSD-3-Clause
#include "depth/depth_projection.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <span>
#include <stdexcept>

namespace slam {
namespace {

constexpr std::uint16_t kFarthest = 10000;  // [mm] of the 1 mm format; what is more is no depth
constexpr int kThinning = 8;                // every so many pixels, in row and column, serve to find the floor

/// 0 is no depth: of two that are left the farther one, of one nothing.
std::uint16_t medianOf(std::uint16_t a, std::uint16_t b, std::uint16_t c) {
  const int missing = (a == 0) + (b == 0) + (c == 0);
  if (missing > 0) return missing > 1 ? std::uint16_t{0} : std::max({a, b, c});
  return std::max(std::min(a, b), std::min(std::max(a, b), c));
}

}  // namespace

DepthProjection::DepthProjection(const DepthProjectionConfig& config)
    : config_(config), floor_(config.floor), slots_(static_cast<int>(std::ceil(config.range_max / config.slot)) + 1) {
  if (!(config.extrinsics.z > config.floor_clearance)) {
    throw std::invalid_argument("the depth camera's height above the floor is not given");
  }
  if (!(config.bearing_step > 0.0) || !(config.robot_height > config.floor_clearance)) {
    throw std::invalid_argument("the depth projection has no beams or no height band");
  }
}

void DepthProjection::prepare(const DepthIntrinsics& intrinsics) {
  rays_.prepare(config_.extrinsics, intrinsics, config_.bearing_step, PseudoLaser::kCapacity);
  const auto beams = static_cast<std::size_t>(rays_.beams());
  laser_.size = rays_.beams();
  laser_.bearing_step = rays_.bearingStep();
  laser_.bearing_min = rays_.bearingMin();
  lift_.assign(beams, 0.0F);
  slot_of_.resize(beams * static_cast<std::size_t>(slots_));
  valid_.resize(beams * DepthRays::kBands);
  min_points_ = std::max(config_.fewest_points,
                         static_cast<int>(config_.points_per_pixel * static_cast<double>(intrinsics.pixels())));
  points_.reserve(intrinsics.pixels() / (kThinning * kThinning) + 1);
  kinds_.resize(static_cast<std::size_t>(intrinsics.width));
  older_.clear();
  oldest_.clear();
  median_.resize(config_.median == 3 ? intrinsics.pixels() : 0);
}

DepthProjection::Status DepthProjection::project(const DepthImage& image) {
  const DepthIntrinsics& intrinsics = image.intrinsics;
  const bool camera = intrinsics.width > 0 && intrinsics.height > 0 && intrinsics.fx > 0.0 && intrinsics.fy > 0.0;
  if (!camera || image.depth.size() != intrinsics.pixels()) return Status::kWrongSize;
  if (!(intrinsics == rays_.intrinsics())) prepare(intrinsics);
  laser_.stamp = image.stamp;
  const std::vector<std::uint16_t>& depth = smoothed(image.depth);
  if (const Status status = trackFloor(image, depth); status != Status::kOk) return status;
  sortPixels(depth);
  laser_.surface_count = 0;
  for (int beam = 0; beam < laser_.size; ++beam) {
    const int slot = firstObstacle(beam);
    const VisibleRanges sight = sightOf(beam);
    PseudoBeam& result = laser_.storage[static_cast<std::size_t>(beam)];
    if (slot >= 0) {
      const float range = rangeAround(beam, slot);
      result = {PseudoBeam::Kind::kHit, range, static_cast<float>(sight.freeBefore(range))};
      addSurfaces(beam, slot);
    } else {
      const VisibleRanges::RangeInterval free = sight.freeInterval(config_.range_max);
      result = {};
      if (free.to - free.from > config_.slot) {
        result = {PseudoBeam::Kind::kFree, static_cast<float>(free.to), static_cast<float>(free.from)};
      }
    }
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
  const auto width = static_cast<std::size_t>(rays_.intrinsics().width);
  const auto height = static_cast<std::size_t>(rays_.intrinsics().height);
  const auto nearest = static_cast<std::uint16_t>(1e3 * config_.range_min);
  const auto camera_height = static_cast<float>(config_.extrinsics.z);
  std::size_t looked = 0, low = 0, below = 0;
  points_.clear();
  for (std::size_t v = kThinning / 2; v < height; v += kThinning) {
    for (std::size_t u = kThinning / 2; u < width; u += kThinning) {
      ++looked;
      const std::uint16_t d = depth[v * width + u];
      if (d < nearest || d > kFarthest) continue;
      const DepthRays::Pixel& pixel = rays_.pixel(v * width + u);
      const float z = 1e-3F * static_cast<float>(d), range = z * pixel.across;
      const float lift = static_cast<float>(floor_.plane().offset) + range * lift_[pixel.beam];
      const float h = camera_height + z * pixel.up;
      low += pixel.up < -0.1F;
      below += h - lift < -static_cast<float>(config_.below) - 0.03F * range;
      if (range > config_.range_max) continue;
      points_.emplace_back(range * rays_.cosine(pixel.beam), range * rays_.sine(pixel.beam), h);
    }
  }
  const std::size_t valid = points_.size();
  if (static_cast<double>(valid) < config_.fewest_valid * static_cast<double>(looked)) {
    // Far walls alone are no fault, if they are seen at all.
    if (low == 0 || valid == 0) return Status::kNoDepth;
  }
  const auto tilt = floor_.update(image.stamp, points_, camera_height);
  if (tilt) {
    tilt_ = *tilt;
    return Status::kTilted;
  }
  const FloorPlane& plane = floor_.plane();
  for (std::size_t beam = 0; beam < lift_.size(); ++beam) {
    lift_[beam] = static_cast<float>(plane.slope_x * rays_.cosine(beam) + plane.slope_y * rays_.sine(beam));
  }
  if (static_cast<double>(below) > config_.most_below * static_cast<double>(std::max<std::size_t>(low, 1))) {
    return Status::kBelowFloor;
  }
  return Status::kOk;
}

/// The depths at which a pixel of a row can show an obstacle, a little wide: what lies outside is floor, above the
/// robot or too far, and is not looked at one by one.
DepthProjection::DepthInterval DepthProjection::obstaclesOf(const DepthRays::Row& row, float lift_low,
                                                            float lift_high) const {
  const double rounding = 1e3 * std::numeric_limits<float>::epsilon();  // [m] of heights of some metres, with room
  const double z = config_.extrinsics.z - floor_.plane().offset;
  const double to_low = config_.floor_clearance - rounding - z, to_high = config_.robot_height + rounding - z;
  // Height gained per depth, over the floor as it lies: the least and the most of the row.
  const double least = row.up_low - std::max(row.across_low * lift_high, row.across_high * lift_high);
  const double most = row.up_high - std::min(row.across_low * lift_low, row.across_high * lift_low);
  double from = config_.range_min, to = config_.range_max / row.across_low;
  if (most < 0.0) to = std::min(to, to_low / most);
  if (least > 0.0) to = std::min(to, to_high / least);
  if (most > 0.0) from = std::max(from, to_low / most);
  if (least < 0.0) from = std::max(from, to_high / least);
  from = 1e3 * from - 1.0, to = std::min(1e3 * to + 1.0, double{kFarthest});
  if (!(from <= to)) return {};
  return {static_cast<std::uint16_t>(from), static_cast<std::uint16_t>(to)};
}

void DepthProjection::sortPixels(const std::vector<std::uint16_t>& depth) {
  enum : std::uint16_t { kValid = 1, kNear = 2 };  // holds a depth; may be an obstacle
  std::fill(slot_of_.begin(), slot_of_.end(), Slot{});
  std::fill(valid_.begin(), valid_.end(), 0);
  const auto nearest = static_cast<std::uint16_t>(1e3 * config_.range_min);
  const auto camera_height = static_cast<float>(config_.extrinsics.z - floor_.plane().offset);
  const auto low = static_cast<float>(config_.floor_clearance), high = static_cast<float>(config_.robot_height);
  const auto longest = static_cast<float>(config_.range_max);
  const auto width = static_cast<std::size_t>(rays_.intrinsics().width);
  const auto height = static_cast<std::size_t>(rays_.intrinsics().height);
  const auto slots_per_metre = static_cast<float>(1.0 / config_.slot);
  const auto valid_span = static_cast<std::uint16_t>(kFarthest - nearest);
  const auto [lift_low, lift_high] = std::ranges::minmax(lift_);
  std::uint16_t* const kinds = kinds_.data();
  for (std::size_t v = 0; v < height; ++v) {
    const std::uint16_t* row = &depth[v * width];
    const DepthInterval near = obstaclesOf(rays_.row(v), lift_low, lift_high);
    std::uint16_t any = 0;
    const auto near_span = static_cast<std::uint16_t>(near.to - near.from);
    for (std::size_t u = 0; u < width; ++u) {  // compilers make it eight at a time
      const std::uint16_t d = row[u];
      const std::uint16_t is_valid = static_cast<std::uint16_t>(d - nearest) <= valid_span;
      const std::uint16_t is_near = static_cast<std::uint16_t>(d - near.from) <= near_span;
      kinds[u] = static_cast<std::uint16_t>(is_valid + is_near + is_near);
      any |= kinds[u];
    }
    int* valid = &valid_[rays_.bandOfRow(v)];
    std::size_t u = 0;
    for (const DepthRays::Run& run : rays_.runs(rays_.row(v))) {
      int count = 0;
      for (; u < run.end; ++u) count += kinds[u] & kValid;
      valid[run.beam * DepthRays::kBands] += count;
    }
    if ((any & kNear) == 0) continue;
    for (u = 0; u < width; ++u) {
      if (kinds[u] != kValid + kNear) continue;
      const DepthRays::Pixel& pixel = rays_.pixel(v * width + u);
      const float z = 1e-3F * static_cast<float>(row[u]), range = z * pixel.across;
      const float above = camera_height + z * pixel.up - range * lift_[pixel.beam];
      if (above < low || above > high || range > longest) continue;
      Slot& slot = slot_of_[static_cast<std::size_t>(pixel.beam) * static_cast<std::size_t>(slots_) +
                            static_cast<std::size_t>(range * slots_per_metre)];
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
    const double range = config_.slot * (i + 1);
    const int reach = i + 1 + static_cast<int>(std::ceil(2.0 * config_.depth_sigma * range * range / config_.slot));
    int best = i;
    for (int j = i + 1; j <= std::min(reach, slots_ - 1) && slots[j].points > slots[best].points; ++j) best = j;
    return best;
  }
  return -1;
}

VisibleRanges DepthProjection::sightOf(int beam) const {
  const double z = config_.extrinsics.z - floor_.plane().offset;
  const auto first = static_cast<std::size_t>(beam) * DepthRays::kBands;
  return {rays_.bands(beam),
          std::span(valid_).subspan(first, DepthRays::kBands),
          {.down = z - config_.floor_clearance,
           .up = config_.robot_height - z,
           .lift = lift_[static_cast<std::size_t>(beam)],
           .range_min = config_.range_min}};
}

/// [m] mean of the points in a slot and its neighbours
float DepthProjection::rangeAround(int beam, int slot) const {
  const Slot* slots = &slot_of_[static_cast<std::size_t>(beam) * static_cast<std::size_t>(slots_)];
  Slot around;
  for (int i = std::max(0, slot - 1); i <= std::min(slot + 1, slots_ - 1); ++i) {
    around.points += slots[i].points;
    around.sum += slots[i].sum;
  }
  return around.sum / static_cast<float>(around.points);
}

/// What is seen of obstacles behind the nearest one: stretches of slots with points.
void DepthProjection::addSurfaces(int beam, int hit_slot) {
  for (int first = hit_slot + 1; first < slots_; ++first) {
    if (!isSurface(beam, first)) continue;
    int last = first;
    while (last + 1 < slots_ && (isSurface(beam, last + 1) || isSurface(beam, last + 2))) ++last;
    laser_.push({static_cast<std::uint16_t>(beam), static_cast<float>(config_.slot * (first + 0.5)),
                 static_cast<float>(config_.slot * (last + 0.5))});
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
  const double range = config_.slot * (slot + 0.5);
  const int noise = 1 + static_cast<int>(std::ceil(2.0 * config_.depth_sigma * range * range / config_.slot));
  for (int s = slot - noise; s <= slot + noise; ++s) {
    if (points(beam, s) > config_.peak * own) return false;
  }
  return true;
}

}  // namespace slam
