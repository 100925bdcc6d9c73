// SPDX-License-Identifier: BSD-3-Clause
#include "slam/mapper.hpp"

#include <algorithm>
#include <cmath>

namespace slam {
namespace {

constexpr double kTolerance = 0.2;  // [cells] a keyframe that moved by less is drawn well enough
constexpr double kLever = 5.0;      // [m] at which a rotation is taken for a motion

bool before(TileIndex a, TileIndex b) { return a.row != b.row ? a.row < b.row : a.column < b.column; }

bool meet(const std::vector<TileIndex>& sorted, const std::vector<TileIndex>& tiles) {
  return std::any_of(tiles.begin(), tiles.end(),
                     [&](TileIndex tile) { return std::binary_search(sorted.begin(), sorted.end(), tile, before); });
}

}  // namespace

void Mapper::add(const MapScan& scan) {
  grid_.add(scan.T_map_base, scan.scan->T_base_lidar, scan.scan->points);
  if (scan.id >= 0) keyframes_.push_back({scan.id, scan.scan, scan.T_map_base, scan.T_map_base, grid_.touched()});
  if (redraw_ && redraw_->patch) redraw_->patch->add(scan.T_map_base, scan.scan->T_base_lidar, scan.scan->points);
}

void Mapper::move(std::span<const Pose2> T_map_base) {
  for (Drawn& keyframe : keyframes_) {
    const auto id = static_cast<std::size_t>(keyframe.id);
    if (id < T_map_base.size()) keyframe.T_map_base = T_map_base[id];
  }
  redraw_.emplace();  // begins anew: what was not finished is still drawn at its old place
}

bool Mapper::hasMoved(const Drawn& keyframe) const {
  const Pose2 change = between(keyframe.T_map_base_drawn, keyframe.T_map_base);
  return std::hypot(change.x, change.y) + kLever * std::abs(change.theta) > kTolerance * config_.resolution;
}

bool Mapper::work(int scans) {
  if (!redraw_) return false;
  scans = examine(scans);
  if (redraw_->examined < keyframes_.size()) return true;
  if (!redraw_->patch) preparePatch();
  for (; scans > 0 && redraw_->next < redraw_->scans.size(); --scans) {
    const auto& [id, T_map_base] = redraw_->scans[redraw_->next++];
    redraw_->patch->add(T_map_base, keyframes_[id].scan->T_base_lidar, keyframes_[id].scan->points);
  }
  if (redraw_->next < redraw_->scans.size()) return true;
  finishRedraw();
  return false;
}

int Mapper::examine(int scans) {
  for (; scans > 0 && redraw_->examined < keyframes_.size(); ++redraw_->examined) {
    const Drawn& keyframe = keyframes_[redraw_->examined];
    if (redraw_->patch || !hasMoved(keyframe)) continue;  // one added since the patch began is in it
    OccupancyGrid alone(config_);
    alone.add(keyframe.T_map_base, keyframe.scan->T_base_lidar, keyframe.scan->points);
    redraw_->moved.push_back({redraw_->examined, keyframe.T_map_base, alone.touched()});
    for (const auto* tiles : {&keyframe.tiles, &alone.touched()}) {
      redraw_->dirty.insert(redraw_->dirty.end(), tiles->begin(), tiles->end());
    }
    --scans;
  }
  return scans;
}

void Mapper::preparePatch() {
  auto& dirty = redraw_->dirty;
  std::sort(dirty.begin(), dirty.end(), before);
  dirty.erase(std::unique(dirty.begin(), dirty.end()), dirty.end());
  redraw_->patch = OccupancyGrid::patch(config_, dirty);
  auto moved = redraw_->moved.begin();
  for (std::size_t i = 0; i < keyframes_.size(); ++i) {
    if (moved != redraw_->moved.end() && moved->keyframe == i) {
      redraw_->scans.emplace_back(i, moved->T_map_base);
      ++moved;
    } else if (meet(dirty, keyframes_[i].tiles)) {
      redraw_->scans.emplace_back(i, keyframes_[i].T_map_base_drawn);
    }
  }
}

void Mapper::finishRedraw() {
  grid_.replaceBy(std::move(*redraw_->patch));
  for (Moved& moved : redraw_->moved) {
    keyframes_[moved.keyframe].T_map_base_drawn = moved.T_map_base;
    keyframes_[moved.keyframe].tiles = std::move(moved.tiles);
  }
  redraw_.reset();
}

void Mapper::load(std::span<const MapScan> keyframes, OccupancyGrid grid, int drawn) {
  reset();
  grid_ = std::move(grid);
  config_.resolution = grid_.resolution();  // patches have to fit
  for (const MapScan& keyframe : keyframes) {
    if (keyframe.id >= drawn) {
      add(keyframe);
      continue;
    }
    OccupancyGrid alone(config_);
    alone.add(keyframe.T_map_base, keyframe.scan->T_base_lidar, keyframe.scan->points);
    keyframes_.push_back({keyframe.id, keyframe.scan, keyframe.T_map_base, keyframe.T_map_base, alone.touched()});
  }
}

void Mapper::reset() { *this = Mapper(configured_); }

std::vector<Eigen::Vector2d> Mapper::path() const {
  std::vector<Eigen::Vector2d> path;
  for (const Drawn& keyframe : keyframes_) path.emplace_back(keyframe.T_map_base.translation());
  return path;
}

}  // namespace slam
