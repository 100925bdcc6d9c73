// SPDX-License-Identifier: BSD-3-Clause
#include "mapping/edited_drawing.hpp"

namespace slam {
namespace {

/// [m] of a tile
Bounds boundsOf(TileIndex tile, double resolution) {
  const double side = OccupancyGrid::kTileSide * resolution;
  const Eigen::Vector2d low(tile.column * side, tile.row * side);
  return {low, low.array() + side};
}

}  // namespace

FreeCells::FreeCells(std::vector<Outline> outlines, double resolution)
    : outlines_(std::move(outlines)), resolution_(resolution) {
  for (const Outline& outline : outlines_) bounds_.push_back(Bounds::of(outline));
}

const FreeCells::Mask* FreeCells::maskOf(TileIndex tile) {
  const auto [known, is_new] = masks_.try_emplace({tile.row, tile.column});
  std::optional<Mask>& mask = known->second;
  if (!is_new) return mask ? &*mask : nullptr;
  const Bounds bounds = boundsOf(tile, resolution_);
  const double half = 0.5 * resolution_;
  for (std::size_t i = 0; i < outlines_.size(); ++i) {
    const Bounds reached = bounds_[i].grown(half);
    if (!reached.meets(bounds)) continue;
    if (!mask) mask.emplace();
    for (std::size_t cell = 0; cell < mask->size(); ++cell) {
      const auto column = cell % OccupancyGrid::kTileSide, row = cell / OccupancyGrid::kTileSide;
      const Eigen::Vector2d centre =
          bounds.low + resolution_ * Eigen::Vector2d(static_cast<double>(column) + 0.5, static_cast<double>(row) + 0.5);
      if (!reached.holds(centre) || mask->test(cell)) continue;
      if (holds(outlines_[i], centre) || touches(outlines_[i], true, centre, half)) mask->set(cell);
    }
  }
  return mask ? &*mask : nullptr;
}

void FreeCells::apply(OccupancyGrid& grid, std::span<const TileIndex> tiles) {
  for (const TileIndex& tile : tiles) {
    if (const Mask* mask = maskOf(tile)) grid.keepFree(tile, *mask);
  }
}

std::vector<TileIndex> tilesUnder(const Outline& outline, const OccupancyGrid& grid) {
  std::vector<TileIndex> under;
  const Bounds bounds = Bounds::of(outline).grown(grid.resolution());
  grid.tiles().forEachTile([&](TileIndex tile, const auto&) {
    if (bounds.meets(boundsOf(tile, grid.resolution()))) under.push_back(tile);
  });
  return under;
}

}  // namespace slam
