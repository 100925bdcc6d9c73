// SPDX-License-Identifier: BSD-3-Clause
#include "bus/messages.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <numbers>
#include <type_traits>
#include <vector>

#include "core/plausibility.hpp"

namespace slam {
namespace {

void copyCovariance(const Eigen::Matrix3d& covariance, double (&out)[9]) {
  Eigen::Map<Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(static_cast<double*>(out)) = covariance;
}

void copyTwist(const Twist2& twist, double (&out)[3]) {
  out[0] = twist.vx;
  out[1] = twist.vy;
  out[2] = twist.omega;
}

/// One member of each item, as the arrays of a message want it.
template <typename Items, typename Member>
auto column(const Items& items, Member member) {
  std::vector<std::decay_t<decltype(std::invoke(member, *items.begin()))>> values;
  values.reserve(items.size());
  for (const auto& item : items) values.push_back(std::invoke(member, item));
  return values;
}

/// 0 is no stamp; beyond the other end nanoseconds would not fit into 64 bits.
bool isStamp(std::int64_t utime) { return utime > 0 && utime < std::numeric_limits<std::int64_t>::max() / 4000; }

WheelSample sampleOf(const wheels_t& message) {
  return {fromMicroseconds(message.utime), {message.x, message.y, message.theta}, message.turn_rate_known != 0};
}

ImuSample sampleOf(const imu_t& message) {
  return {fromMicroseconds(message.utime), Eigen::Vector3d(message.gyro), Eigen::Vector3d(message.accel)};
}

}  // namespace

bot_core::pose_t toPoseMessage(const PoseEstimate& estimate, std::int64_t utime) {
  bot_core::pose_t message{};
  const Pose2& T = estimate.T_map_base;
  const double c = std::cos(T.theta), s = std::sin(T.theta);
  message.utime = utime;
  message.pos[0] = T.x;
  message.pos[1] = T.y;
  message.vel[0] = c * estimate.twist.vx - s * estimate.twist.vy;
  message.vel[1] = s * estimate.twist.vx + c * estimate.twist.vy;
  message.orientation[0] = std::cos(T.theta / 2.0);
  message.orientation[3] = std::sin(T.theta / 2.0);
  message.rotation_rate[2] = estimate.twist.omega;
  return message;
}

pose_estimate_t toMessage(const PoseEstimate& estimate, std::int64_t utime, std::int32_t map_id) {
  pose_estimate_t message{};
  message.utime = utime;
  message.map_id = map_id;
  message.x = estimate.T_map_base.x;
  message.y = estimate.T_map_base.y;
  message.theta = estimate.T_map_base.theta;
  copyCovariance(estimate.covariance, message.covariance);
  copyTwist(estimate.twist, message.twist);
  message.state = static_cast<std::uint8_t>(estimate.state);
  message.match_quality = static_cast<float>(estimate.match_quality);
  return message;
}

odometry_t toMessage(const OdometryEstimate& estimate, std::int64_t utime) {
  odometry_t message{};
  message.utime = utime;
  message.x = estimate.T_odom_base.x;
  message.y = estimate.T_odom_base.y;
  message.theta = estimate.T_odom_base.theta;
  copyCovariance(estimate.covariance, message.covariance);
  copyTwist(estimate.twist, message.twist);
  message.gyro_bias = estimate.gyro_bias;
  message.slip = estimate.slip;
  message.standstill = estimate.standstill;
  message.map_odom[0] = estimate.T_map_odom.x;
  message.map_odom[1] = estimate.T_map_odom.y;
  message.map_odom[2] = estimate.T_map_odom.theta;
  return message;
}

scan_t toMessage(const LaserScan& scan, std::int64_t utime) {
  scan_t message{};
  message.utime = utime;
  message.range_min = scan.range_min;
  message.range_max = scan.range_max;
  message.nbeams = scan.size;
  message.ranges = column(scan.beams(), &Beam::range);
  message.bearings = column(scan.beams(), &Beam::bearing);
  message.time_offsets = column(scan.beams(), &Beam::time_offset);
  message.intensities = column(scan.beams(), &Beam::intensity);
  return message;
}

wheels_t toMessage(const WheelSample& sample, std::int64_t utime, std::span<const double> angles) {
  wheels_t message{};
  message.utime = utime;
  message.x = sample.T_wheels_base.x;
  message.y = sample.T_wheels_base.y;
  message.theta = sample.T_wheels_base.theta;
  message.turn_rate_known = sample.turn_rate_known;
  message.nwheels = static_cast<std::int32_t>(angles.size());
  message.angles.assign(angles.begin(), angles.end());
  return message;
}

imu_t toMessage(const ImuSample& sample, std::int64_t utime) {
  imu_t message{};
  message.utime = utime;
  for (int i = 0; i < 3; ++i) {
    message.gyro[i] = sample.gyro[i];
    message.accel[i] = sample.accel[i];
  }
  return message;
}

depth_t toMessage(const PseudoLaser& laser, std::int64_t utime) {
  depth_t message{};
  message.utime = utime;
  message.bearing_min = laser.bearing_min;
  message.bearing_step = laser.bearing_step;
  message.nbeams = laser.size;
  message.ranges = column(laser.beams(), &PseudoBeam::range);
  message.free_from = column(laser.beams(), &PseudoBeam::free_from);
  message.kinds = column(laser.beams(), [](const PseudoBeam& beam) { return static_cast<std::uint8_t>(beam.kind); });
  message.nsurfaces = laser.surface_count;
  const auto beamOf = [](const PseudoLaser::Surface& surface) { return static_cast<std::int16_t>(surface.beam); };
  message.surface_beams = column(laser.surfaces(), beamOf);
  message.surface_from = column(laser.surfaces(), &PseudoLaser::Surface::from);
  message.surface_to = column(laser.surfaces(), &PseudoLaser::Surface::to);
  return message;
}

bot_core::planar_lidar_t toLaserMessage(const LaserScan& scan, std::int64_t utime, int beams) {
  bot_core::planar_lidar_t message{};
  const double step = 2.0 * std::numbers::pi / beams;
  message.utime = utime;
  message.rad0 = static_cast<float>(-std::numbers::pi);
  message.radstep = static_cast<float>(step);
  message.nranges = message.nintensities = beams;
  message.ranges.assign(static_cast<std::size_t>(beams), 0.0F);
  message.intensities.assign(static_cast<std::size_t>(beams), 0.0F);
  for (const Beam& beam : scan.beams()) {
    if (!scan.isReturn(beam)) continue;
    const double turns = (static_cast<double>(beam.bearing) + std::numbers::pi) / step;
    const auto i = static_cast<std::size_t>(((std::lround(turns) % beams) + beams) % beams);
    if (message.ranges[i] != 0.0F && message.ranges[i] <= beam.range) continue;
    message.ranges[i] = beam.range;
    message.intensities[i] = beam.intensity;
  }
  return message;
}

map_meta_t toMetaMessage(const OccupancyGrid& grid, std::int64_t utime, std::int32_t map_id, std::int32_t keyframes) {
  map_meta_t message{};
  message.utime = utime;
  message.map_id = map_id;
  message.resolution = grid.resolution();
  message.tile_side = OccupancyGrid::kTileSide;
  message.tiles = grid.tiles().tileCount();
  message.keyframes = keyframes;
  bool first = true;
  grid.tiles().forEachTile([&](TileIndex tile, const OccupancyGrid::Tiles::Tile&) {
    message.column_min = first ? tile.column : std::min(message.column_min, tile.column);
    message.column_max = first ? tile.column : std::max(message.column_max, tile.column);
    message.row_min = first ? tile.row : std::min(message.row_min, tile.row);
    message.row_max = first ? tile.row : std::max(message.row_max, tile.row);
    first = false;
  });
  return message;
}

map_tile_t toTileMessage(const OccupancyGrid& grid, TileIndex tile, std::int64_t utime, std::int32_t map_id,
                         MapLayer layer) {
  constexpr std::uint8_t kUnknown = 255;
  map_tile_t message{};
  message.utime = utime;
  message.map_id = map_id;
  message.column = tile.column;
  message.row = tile.row;
  message.side = OccupancyGrid::kTileSide;
  message.ncells = message.side * message.side;
  message.cells.assign(static_cast<std::size_t>(message.ncells), kUnknown);
  if (const auto* data = grid.tiles().find(tile)) {
    std::transform(data->cells.begin(), data->cells.end(), message.cells.begin(), [&](const OccupancyGrid::Cell& cell) {
      const std::optional<LogOdds> value = grid.seenBy(layer, cell);
      return value ? static_cast<std::uint8_t>(std::lround(100.0 * toProbability(*value))) : kUnknown;
    });
  }
  return message;
}

Refusal refusalOf(const scan_t& message) {
  if (!isStamp(message.utime)) return Refusal::kStamp;
  const bool limits = std::isfinite(message.range_min) && std::isfinite(message.range_max) &&
                      message.range_min >= 0.0F && (message.range_max > message.range_min || message.range_max == 0.0F);
  return limits ? Refusal::kNone : Refusal::kLimits;
}

Refusal refusalOf(const wheels_t& message) {
  if (!isStamp(message.utime)) return Refusal::kStamp;
  return isPlausible(sampleOf(message)) ? Refusal::kNone : Refusal::kValues;
}

Refusal refusalOf(const imu_t& message) {
  if (!isStamp(message.utime)) return Refusal::kStamp;
  return isPlausible(sampleOf(message)) ? Refusal::kNone : Refusal::kValues;
}

Refusal refusalOf(const drive_t& message) {
  if (!isStamp(message.utime)) return Refusal::kStamp;
  const bool finite = std::isfinite(message.vx) && std::isfinite(message.vy) && std::isfinite(message.omega);
  return finite ? Refusal::kNone : Refusal::kValues;
}

Refusal refusalOf(const depth_t& message) {
  if (!isStamp(message.utime)) return Refusal::kStamp;
  if (message.nbeams > PseudoLaser::kCapacity) return Refusal::kSize;
  const bool bearings = std::isfinite(message.bearing_min) && std::isfinite(message.bearing_step) &&
                        std::abs(message.bearing_min) < 10.0F && std::abs(message.bearing_step) < 1.0F;
  return bearings ? Refusal::kNone : Refusal::kValues;
}

int thinnedBeams(const scan_t& message) { return std::max(0, message.nbeams - LaserScan::kCapacity); }

std::optional<LaserScan> fromMessage(const scan_t& message) {
  // The one that is returned, as a second one would take 64 KB more of the stack; begun in place, as an empty one would
  // clear as much.
  std::optional<LaserScan> scan(std::in_place);
  if (refusalOf(message) != Refusal::kNone) {
    scan.reset();
    return scan;
  }
  scan->stamp = fromMicroseconds(message.utime);
  scan->range_min = message.range_min;
  // Not given: the configured one is the limit alone.
  scan->range_max = message.range_max == 0.0F ? std::numeric_limits<float>::max() : message.range_max;
  const std::size_t all = message.ranges.size(), used = std::min<std::size_t>(all, LaserScan::kCapacity);
  for (std::size_t k = 0; k < used; ++k) {
    const std::size_t i = k * all / used;
    scan->push(plausible({message.ranges[i], message.bearings[i], message.time_offsets[i], message.intensities[i]}));
  }
  return scan;
}

std::optional<WheelSample> fromMessage(const wheels_t& message) {
  if (refusalOf(message) != Refusal::kNone) return std::nullopt;
  return sampleOf(message);
}

std::optional<ImuSample> fromMessage(const imu_t& message) {
  if (refusalOf(message) != Refusal::kNone) return std::nullopt;
  return sampleOf(message);
}

std::optional<Twist2> fromMessage(const drive_t& message) {
  if (refusalOf(message) != Refusal::kNone) return std::nullopt;
  return Twist2{message.vx, message.vy, message.omega};
}

std::optional<PseudoLaser> fromMessage(const depth_t& message) {
  if (refusalOf(message) != Refusal::kNone) return std::nullopt;
  PseudoLaser laser;
  laser.stamp = fromMicroseconds(message.utime);
  laser.bearing_min = message.bearing_min;
  laser.bearing_step = message.bearing_step;
  laser.size = message.nbeams;
  for (std::size_t i = 0; i < message.ranges.size(); ++i) {
    const float range = message.ranges[i], from = message.free_from[i];
    const bool sound = range > 0.0F && from >= 0.0F && from <= range && range < kPlausible.depth_range;
    const auto kind = static_cast<std::uint8_t>(message.kinds[i]);
    if (!sound || kind == 0 || kind > static_cast<std::uint8_t>(PseudoBeam::Kind::kHit)) continue;
    laser.storage[i] = {static_cast<PseudoBeam::Kind>(kind), range, from};
  }
  for (std::size_t i = 0; i < message.surface_beams.size(); ++i) {
    const float from = message.surface_from[i], to = message.surface_to[i];
    const bool sound = message.surface_beams[i] >= 0 && message.surface_beams[i] < laser.size && from > 0.0F &&
                       to >= from && to < kPlausible.depth_range;
    if (sound) laser.push({static_cast<std::uint16_t>(message.surface_beams[i]), from, to});
  }
  return laser;
}

}  // namespace slam
