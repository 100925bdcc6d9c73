// SPDX-License-Identifier: BSD-3-Clause
#include "slam/merge/cell_agreement.hpp"

#include <cmath>

namespace slam {
namespace {

/// @param reach [cells] around each occupied one of `seen` that are looked at in `other`
void count(const OccupancyGrid& seen, const OccupancyGrid& other, int reach, CellAgreement& agreement) {
  constexpr int kSide = OccupancyGrid::kTileSide;
  const auto countCell = [&](CellIndex cell) {
    bool all_free = true;
    for (int row = cell.row - reach; row <= cell.row + reach; ++row) {
      for (int column = cell.column - reach; column <= cell.column + reach; ++column) {
        const LogOdds log_odds = other.logOdds({column, row});
        if (log_odds > 0) {
          ++agreement.same;
          return;
        }
        all_free = all_free && log_odds < 0;
      }
    }
    agreement.different += all_free ? 1 : 0;
  };
  seen.tiles().forEachTile([&](TileIndex tile, const OccupancyGrid::Tiles::Tile& cells) {
    for (int row = 0; row < kSide; ++row) {
      for (int column = 0; column < kSide; ++column) {
        if (seen.fused(cells.at(column, row)) > 0) countCell({tile.column * kSide + column, tile.row * kSide + row});
      }
    }
  });
}

}  // namespace

CellAgreement compareCells(const OccupancyGrid& a, const OccupancyGrid& b, double tolerance) {
  const int reach = static_cast<int>(std::ceil(tolerance / a.resolution() - 1e-9));
  CellAgreement agreement;
  count(a, b, reach, agreement);
  count(b, a, reach, agreement);
  return agreement;
}

}  // namespace slam
