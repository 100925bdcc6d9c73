// SPDX-License-Identifier: BSD-3-Clause
#include "mapping/mapper.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace slam {
namespace {

constexpr double kTolerance = 0.2;  // [cells] what moved by less is drawn well enough
constexpr double kLever = 5.0;      // [m] at which a rotation is taken for a motion
constexpr ViewMemoryConfig kViews;

bool before(TileIndex a, TileIndex b) { return a.row != b.row ? a.row < b.row : a.column < b.column; }

bool meet(const std::vector<TileIndex>& sorted, const std::vector<TileIndex>& tiles) {
  return std::any_of(tiles.begin(), tiles.end(),
                     [&](TileIndex tile) { return std::binary_search(sorted.begin(), sorted.end(), tile, before); });
}

}  // namespace

std::shared_ptr<const DepthView> shownOf(const MapView& view, std::span<const EditedDrawing::Erased> erased) {
  std::shared_ptr<const DepthView> shown = view.view;
  for (const EditedDrawing::Erased& edit : erased) {
    const auto anchor = edit.T_keyframe_map.find(view.keyframe);
    if (edit.edit <= view.edit || anchor == edit.T_keyframe_map.end()) continue;
    const Pose2 T_map_depth = anchor->second.inverse() * view.T_keyframe_base * view.view->T_base_depth;
    const auto isErased = [&](float bearing, float range) {
      const double direction = T_map_depth.theta + static_cast<double>(bearing);
      return holds(edit.outline,
                   T_map_depth.translation() +
                       static_cast<double>(range) * Eigen::Vector2d(std::cos(direction), std::sin(direction)));
    };
    auto rest = std::make_shared<DepthView>(*shown);
    const auto beams = std::erase_if(
        rest->beams, [&](const DepthView::Beam& beam) { return beam.hit && isErased(beam.bearing, beam.range); });
    const auto surfaces = std::erase_if(rest->surfaces, [&](const DepthView::Surface& surface) {
      return isErased(surface.bearing, surface.from) || isErased(surface.bearing, surface.to);
    });
    if (beams + surfaces > 0) shown = std::move(rest);
  }
  return shown;
}

Mapper::Drawn Mapper::drawnOf(const MapView& view, std::span<const EditedDrawing::Erased> erased) {
  Drawn drawn{view.keyframe, view.T_keyframe_base, nullptr, view.view, view.T_map_keyframe, view.T_map_base(), {}};
  drawn.edit = view.edit;
  drawn.shown = shownOf(view, erased);
  return drawn;
}

void Mapper::Drawn::drawInto(OccupancyGrid& grid, const Pose2& T_map_base) const {
  scan ? grid.add(T_map_base, scan->T_base_lidar, scan->points) : grid.add(T_map_base * shown->T_base_depth, *shown);
}

void Mapper::draw(const Drawn& drawn) {
  drawn.drawInto(grid_, drawn.T_map_base());
  if (!free_.empty()) free_.apply(grid_, grid_.touched());
  if (redraw_ && redraw_->patch) drawn.drawInto(*redraw_->patch, drawn.T_map_base());
}

void Mapper::add(const MapScan& scan) {
  if (Drawn* known = scan.id < 0 ? nullptr : drawnScan(scan.id)) {
    known->scan = scan.scan;
    known->T_map_keyframe = scan.T_map_base;
    known->stale = true;
    keepLate();
    redraw_ = Redraw{};
    return;
  }
  Drawn drawn{scan.id, {}, scan.scan, nullptr, scan.T_map_base, scan.T_map_base, {}};
  draw(drawn);
  if (scan.id < 0) return;
  drawn.tiles = grid_.touched();
  keep(std::move(drawn));
}

void Mapper::add(const MapView& view) {
  Drawn drawn = drawnOf(view, erased_);
  draw(drawn);
  drawn.tiles = grid_.touched();
  if (redraw_) {  // which counts what is kept: no view may take another one's place now
    late_.push_back(std::move(drawn));
  } else {
    keep(std::move(drawn));
  }
}

/// Looked for from the newest one, near which it is, or nullptr.
Mapper::Drawn* Mapper::drawnScan(int keyframe) {
  for (auto drawn = drawn_.rbegin(); drawn != drawn_.rend(); ++drawn) {
    if (drawn->scan && drawn->keyframe <= keyframe) return drawn->keyframe == keyframe ? &*drawn : nullptr;
  }
  return nullptr;
}

/// Where a view goes that takes another one's place, or nullptr.
std::size_t* Mapper::placeOf(const Drawn& view) {
  auto& kept = views_of_[static_cast<std::size_t>(view.keyframe)];
  for (std::size_t& i : kept) {
    const Pose2 apart = between(drawn_[i].T_keyframe_base, view.T_keyframe_base);
    const bool same =
        std::hypot(apart.x, apart.y) < kViews.same_distance && std::abs(apart.theta) < kViews.same_rotation;
    if (same) return &i;
  }
  if (kept.size() < kViews.per_keyframe) return nullptr;
  return &*std::min_element(kept.begin(), kept.end(), [&](std::size_t a, std::size_t b) {
    return drawn_[a].view->stamp < drawn_[b].view->stamp;
  });
}

void Mapper::keep(Drawn drawn) {
  if (drawn.scan) {
    ++keyframes_;
    drawn_.push_back(std::move(drawn));
    return;
  }
  const auto keyframe = static_cast<std::size_t>(drawn.keyframe);
  if (views_of_.size() <= keyframe) views_of_.resize(keyframe + 1);
  if (const std::size_t* place = placeOf(drawn)) {
    drawn_[*place] = std::move(drawn);
  } else {
    views_of_[keyframe].push_back(drawn_.size());
    drawn_.push_back(std::move(drawn));
  }
}

void Mapper::keepLate() {
  for (Drawn& view : late_) keep(std::move(view));
  late_.clear();
}

void Mapper::move(std::span<const Pose2> T_map_base) {
  keepLate();
  for (Drawn& drawn : drawn_) {
    const auto id = static_cast<std::size_t>(drawn.keyframe);
    if (id < T_map_base.size()) drawn.T_map_keyframe = T_map_base[id];
  }
  redraw_ = Redraw{};  // begins anew: what was not finished is still drawn at its old place
}

void Mapper::apply(const EditedDrawing& edits, std::span<const Outline> anew) {
  keepLate();
  const auto touch = [this](const Outline& outline) {
    const auto under = tilesUnder(outline, grid_);
    edited_.insert(edited_.end(), under.begin(), under.end());
  };
  for (const Outline& outline : anew) touch(outline);
  if (edits.free != free_.outlines()) {
    for (const auto* outlines : {&free_.outlines(), &edits.free})
      std::for_each(outlines->begin(), outlines->end(), touch);
    free_ = FreeCells(edits.free, config_.resolution);
  }
  erased_ = edits.erased;
  bool stale = false;
  for (Drawn& drawn : drawn_) {
    if (!drawn.view) continue;
    Drawn now = drawnOf({drawn.keyframe, drawn.T_map_keyframe, drawn.T_keyframe_base, drawn.view, drawn.edit}, erased_);
    const auto size = [](const DepthView& view) { return view.beams.size() + view.surfaces.size(); };
    if (size(*now.shown) == size(*drawn.shown)) continue;
    drawn.shown = std::move(now.shown);
    stale = drawn.stale = true;
  }
  if (stale || !edited_.empty()) redraw_ = Redraw{};
}

void Mapper::forgetBefore(int keyframe) {
  if (drawn_.empty() || drawn_.front().keyframe >= keyframe) return;  // they are in their order
  work(std::numeric_limits<int>::max());
  std::vector<Drawn> all = std::exchange(drawn_, {});
  keyframes_ = 0;
  views_of_.clear();
  redraw_ = Redraw{};
  for (Drawn& drawn : all) {
    if (drawn.keyframe < keyframe) {
      redraw_->dirty.insert(redraw_->dirty.end(), drawn.tiles.begin(), drawn.tiles.end());
    } else {
      keep(std::move(drawn));
    }
  }
  work(std::numeric_limits<int>::max());
}

bool Mapper::hasMoved(const Drawn& drawn) const {
  if (drawn.stale) return true;
  const Pose2 change = between(drawn.T_map_base_drawn, drawn.T_map_base());
  return std::hypot(change.x, change.y) + kLever * std::abs(change.theta) > kTolerance * config_.resolution;
}

bool Mapper::work(int scans) {
  if (!redraw_) return false;
  scans = examine(scans);
  if (redraw_->examined < drawn_.size()) return true;
  if (!redraw_->patch) preparePatch();
  for (; scans > 0 && redraw_->next < redraw_->scans.size(); --scans) {
    const auto& [index, T_map_base] = redraw_->scans[redraw_->next++];
    drawn_[index].drawInto(*redraw_->patch, T_map_base);
  }
  if (redraw_->next < redraw_->scans.size()) return true;
  finishRedraw();
  return false;
}

int Mapper::examine(int scans) {
  for (; scans > 0 && redraw_->examined < drawn_.size(); ++redraw_->examined) {
    const Drawn& drawn = drawn_[redraw_->examined];
    if (redraw_->patch || !hasMoved(drawn)) continue;  // one added since the patch began is in it
    OccupancyGrid alone(config_);
    drawn.drawInto(alone, drawn.T_map_base());
    redraw_->moved.push_back({redraw_->examined, drawn.T_map_base(), alone.touched()});
    for (const auto* tiles : {&drawn.tiles, &alone.touched()}) {
      redraw_->dirty.insert(redraw_->dirty.end(), tiles->begin(), tiles->end());
    }
    --scans;
  }
  return scans;
}

void Mapper::preparePatch() {
  auto& dirty = redraw_->dirty;
  dirty.insert(dirty.end(), edited_.begin(), edited_.end());
  std::sort(dirty.begin(), dirty.end(), before);
  dirty.erase(std::unique(dirty.begin(), dirty.end()), dirty.end());
  redraw_->patch = OccupancyGrid::patch(config_, dirty);
  auto moved = redraw_->moved.begin();
  for (std::size_t i = 0; i < drawn_.size(); ++i) {
    if (moved != redraw_->moved.end() && moved->index == i) {
      redraw_->scans.emplace_back(i, moved->T_map_base);
      ++moved;
    } else if (meet(dirty, drawn_[i].tiles)) {
      redraw_->scans.emplace_back(i, drawn_[i].T_map_base_drawn);
    }
  }
  for (const Drawn& view : late_) {
    if (meet(dirty, view.tiles)) view.drawInto(*redraw_->patch, view.T_map_base());
  }
}

void Mapper::finishRedraw() {
  if (!free_.empty()) free_.apply(*redraw_->patch, redraw_->dirty);
  edited_.clear();
  grid_.replaceBy(std::move(*redraw_->patch));
  for (Moved& moved : redraw_->moved) {
    drawn_[moved.index].T_map_base_drawn = moved.T_map_base;
    drawn_[moved.index].tiles = std::move(moved.tiles);
    drawn_[moved.index].stale = false;
  }
  redraw_.reset();
  keepLate();
}

void Mapper::load(std::span<const MapScan> keyframes, std::span<const MapView> views, OccupancyGrid grid, int drawn,
                  const EditedDrawing& edits) {
  reset();
  grid_ = std::move(grid);
  config_.resolution = grid_.resolution();  // patches have to fit
  free_ = FreeCells(edits.free, config_.resolution);
  erased_ = edits.erased;
  const auto keepUndrawn = [this](Drawn undrawn) {
    OccupancyGrid alone(config_);
    undrawn.drawInto(alone, undrawn.T_map_base());
    undrawn.tiles = alone.touched();
    keep(std::move(undrawn));
  };
  for (const MapScan& keyframe : keyframes) {
    if (keyframe.id < drawn) {
      keepUndrawn({keyframe.id, {}, keyframe.scan, nullptr, keyframe.T_map_base, keyframe.T_map_base, {}});
    } else {
      add(keyframe);
    }
  }
  for (const MapView& view : views) {
    keepUndrawn(drawnOf(view, erased_));
  }
}

void Mapper::reset() { *this = Mapper(configured_); }

std::vector<Eigen::Vector2d> Mapper::path() const {
  std::vector<Eigen::Vector2d> path;
  for (const Drawn& drawn : drawn_) {
    if (drawn.scan) path.emplace_back(drawn.T_map_keyframe.translation());
  }
  return path;
}

std::vector<MapView> Mapper::views() const {
  std::vector<MapView> views;
  for (const Drawn& drawn : drawn_) {
    if (drawn.view)
      views.push_back({drawn.keyframe, drawn.T_map_keyframe, drawn.T_keyframe_base, drawn.view, drawn.edit});
  }
  return views;
}

}  // namespace slam
