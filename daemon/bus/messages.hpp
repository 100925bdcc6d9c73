// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <bot_core/planar_lidar_t.hpp>
#include <bot_core/pose_t.hpp>
#include <cstdint>
#include <optional>
#include <slam/depth_t.hpp>
#include <slam/drive_t.hpp>
#include <slam/imu_t.hpp>
#include <slam/map_meta_t.hpp>
#include <slam/map_tile_t.hpp>
#include <slam/odometry_t.hpp>
#include <slam/pose_estimate_t.hpp>
#include <slam/scan_t.hpp>
#include <slam/wheels_t.hpp>
#include <span>

#include "bus/refusal.hpp"
#include "core/estimates.hpp"
#include "core/pseudo_laser.hpp"
#include "core/samples.hpp"
#include "core/scan.hpp"
#include "mapping/occupancy_grid.hpp"

/// Core types to LCM messages and back. `utime` [µs since the epoch] is given where the message carries one: the stamp
/// itself belongs to CLOCK_MONOTONIC, and who publishes knows the difference.
namespace slam {

bot_core::pose_t toPoseMessage(const PoseEstimate& estimate, std::int64_t utime);
pose_estimate_t toMessage(const PoseEstimate& estimate, std::int64_t utime, std::int32_t map_id);
odometry_t toMessage(const OdometryEstimate& estimate, std::int64_t utime);
scan_t toMessage(const LaserScan& scan, std::int64_t utime);
/// @param angles [rad] of each wheel, may be empty
wheels_t toMessage(const WheelSample& sample, std::int64_t utime, std::span<const double> angles = {});
imu_t toMessage(const ImuSample& sample, std::int64_t utime);
depth_t toMessage(const PseudoLaser& laser, std::int64_t utime);
/// The scan resampled to `beams` equal bearing steps over the full turn; the nearest return of a step counts.
bot_core::planar_lidar_t toLaserMessage(const LaserScan& scan, std::int64_t utime, int beams = 720);
map_meta_t toMetaMessage(const OccupancyGrid& grid, std::int64_t utime, std::int32_t map_id, std::int32_t keyframes);
map_tile_t toTileMessage(const OccupancyGrid& grid, TileIndex tile, std::int64_t utime, std::int32_t map_id,
                         MapLayer layer = MapLayer::kBoth);

/// Why a message cannot be a measurement: no utime, values that are not plausible, limits that are none.
Refusal refusalOf(const scan_t& message);
Refusal refusalOf(const wheels_t& message);
Refusal refusalOf(const imu_t& message);
Refusal refusalOf(const depth_t& message);
Refusal refusalOf(const drive_t& message);

/// Beams of a scan that fromMessage() leaves out, evenly over the turn, because a LaserScan has room for fewer.
int thinnedBeams(const scan_t& message);

/// Stamps of the results count from the message's epoch: stamp = fromMicroseconds(utime).
/// @return std::nullopt where refusalOf() has a reason; single bad beams become "no return" or "unknown"
std::optional<LaserScan> fromMessage(const scan_t& message);
std::optional<WheelSample> fromMessage(const wheels_t& message);
std::optional<ImuSample> fromMessage(const imu_t& message);
std::optional<PseudoLaser> fromMessage(const depth_t& message);
std::optional<Twist2> fromMessage(const drive_t& message);

}  // namespace slam
