// SPDX-License-Identifier: BSD-3-Clause
#include "tools/web/web_state.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "bus/messages.hpp"
#include "core/plausibility.hpp"
#include "matching/deskew.hpp"

namespace slam {
namespace {

using namespace std::chrono_literals;
constexpr double kTrailStep = 0.05;       // [m]
constexpr Duration kExtrapolate = 250ms;  // beams are newer than the newest pose by a turn of the lidar at most
constexpr Duration kGap = 1s;             // poses further apart are not joined

bool isSound(const pose_estimate_t& pose) {
  return isPlausible(Pose2{pose.x, pose.y, pose.theta}, kPlausible.stored_farthest) && pose.utime > 0 &&
         pose.utime < std::numeric_limits<std::int64_t>::max() / 4000;
}

}  // namespace

void DrivenPath::add(Timestamp stamp, const Pose2& T_map_base) {
  if (!poses_.empty() && (stamp < poses_.newest().stamp - kGap || stamp > poses_.newest().stamp + kGap)) poses_.clear();
  poses_.push(stamp, T_map_base);
}

void DrivenPath::extendTrail(const Eigen::Vector2d& at) {
  if (!trail_.empty() && (at - trail_.back()).norm() < kTrailStep) return;
  trail_.push_back(at);
  if (trail_.size() <= kLongestTrail) return;
  std::deque<Eigen::Vector2d> coarser;
  for (std::size_t i = 0; i < trail_.size(); ++i) {
    if (i % 2 == 0 || i > kLongestTrail / 2) coarser.push_back(trail_[i]);
  }
  trail_ = std::move(coarser);
}

void DrivenPath::clear() {
  poses_.clear();
  trail_.clear();
}

WebState::WebState(const Config& config)
    : lidar_(config.front_end.lidar),
      depth_mount_{config.depth_device.projection.extrinsics.levelled(), config.front_end.depth.time_offset} {}

void WebState::take(const pose_estimate_t& pose, Timestamp now) {
  if (!isSound(pose)) return countBadMessage();
  last_received_ = now;
  if (!pose_.newest || pose.map_id != pose_.newest->map_id) beginMap(pose.map_id);
  const Timestamp stamp = fromMicroseconds(pose.utime);
  path_.add(stamp, {pose.x, pose.y, pose.theta});
  if (pose_.newest && pose_.newest->state != pose.state) pose_.since = pose.utime;
  pose_.newest = pose;
  ++serials_.pose;
  day_.take(pose);
  const auto state = static_cast<LocalisationState>(static_cast<std::uint8_t>(pose.state));
  if (state == LocalisationState::kLocalised || state == LocalisationState::kDegraded)
    path_.extendTrail({pose.x, pose.y});
}

void WebState::take(const health_t& health, Timestamp now) {
  last_received_ = now;
  const bool restarted = health_ && health.uptime < health_->uptime;
  for (const counter_t& counter : health.counters) {
    if (counter.name != "loop_closures") continue;
    if (closures_.counted && !restarted && counter.value > *closures_.counted && pose_.newest) {
      closures_.all.push_back({{pose_.newest->x, pose_.newest->y}, counter.value});
      if (closures_.all.size() > kMostClosures) closures_.all.pop_front();
      ++serials_.closure;
    }
    closures_.counted = counter.value;
  }
  health_ = health;
  day_.take(health, problems_);
  ++serials_.health;
}

void WebState::take(const problems_t& problems, Timestamp now) {
  last_received_ = now;
  problems_ = problems;
}

void WebState::add(Points& points, const Eigen::Vector2d& p_map) {
  if (points.size() < kMostPoints && p_map.allFinite()) points.push_back(p_map);
}

void WebState::take(const scan_t& message, Timestamp now) {
  const auto scan = fromMessage(message);
  if (!scan) return countBadMessage();
  last_received_ = now;
  const Timestamp stamp = scan->stamp + fromSeconds(lidar_.time_offset);
  const auto T_map_base = path_.poses().at(stamp, kExtrapolate);
  if (!T_map_base) return;
  ScanPoints points;
  const RangeLimits limits{std::max(scan->range_min, static_cast<float>(lidar_.range_min)),
                           std::min(scan->range_max, static_cast<float>(lidar_.range_max))};
  deskew(*scan, limits, stamp, lidar_.mounting(), path_.poses(), points);
  seen_.scan.clear();
  const std::size_t step = points.size() / kMostPoints + 1;
  for (std::size_t i = 0; i < points.size(); i += step) add(seen_.scan, *T_map_base * points[i].position);
  ++serials_.scan;
}

void WebState::take(const depth_t& message, Timestamp now) {
  const auto laser = fromMessage(message);
  if (!laser) return countBadMessage();
  last_received_ = now;
  const auto T_map_base = path_.poses().at(laser->stamp + fromSeconds(depth_mount_.time_offset), kExtrapolate);
  if (!T_map_base) return;
  const Pose2 T_map_depth = *T_map_base * depth_mount_.T_base_camera;
  seen_.depth.clear();
  for (int i = 0; i < laser->size; ++i) {
    const PseudoBeam& beam = laser->beams()[static_cast<std::size_t>(i)];
    if (beam.kind != PseudoBeam::Kind::kHit) continue;
    const double bearing = laser->bearing(i), range = beam.range;
    add(seen_.depth, T_map_depth * Eigen::Vector2d(range * std::cos(bearing), range * std::sin(bearing)));
  }
  ++serials_.depth;
}

void WebState::beginMap(std::int32_t map_id) {
  tiles_.begin(map_id);
  edits_.begin(map_id);
  path_.clear();
  closures_.all.clear();
  seen_.scan.clear();
  seen_.depth.clear();
  ++serials_.map;
}

void WebState::take(const map_meta_t& meta, Timestamp now) {
  last_received_ = now;
  if (meta.map_id != tiles_.mapId()) beginMap(meta.map_id);
  tiles_.setResolution(meta.resolution);
  meta_ = meta;
}

void WebState::take(MapLayer layer, const map_tile_t& tile, Timestamp now) {
  last_received_ = now;
  tiles_.put(layer, tile);
}

void WebState::take(const map_edit_t& edit, Timestamp now) {
  if (!edits_.take(edit)) return countBadMessage();
  last_received_ = now;
}

}  // namespace slam
