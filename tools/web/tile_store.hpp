// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <slam/map_tile_t.hpp>
#include <span>
#include <string>

#include "mapping/map_image.hpp"
#include "mapping/occupancy_grid.hpp"

namespace slam {

/// Compresses blocks so that any row of them, in any order, is the body of one gzip stream: each is compressed once,
/// whoever asks for it.
class BlockDeflater {
 public:
  struct Block {
    std::string deflated;
    std::uint32_t checksum = 0;  ///< CRC-32 of what was compressed
    std::size_t size = 0;        ///< [bytes] of it
  };

  BlockDeflater();
  ~BlockDeflater();
  BlockDeflater(const BlockDeflater&) = delete;
  BlockDeflater& operator=(const BlockDeflater&) = delete;

  Block compress(std::span<const std::uint8_t> bytes);

 private:
  struct Stream;
  std::unique_ptr<Stream> stream_;
};

/// What is kept of an occupancy [percent]: five shades that map_server's thresholds part alike. The last looks at a
/// cell that is sure already, and the pattern of rays in free space, would be most of what is sent.
constexpr std::uint8_t shadeOf(std::uint8_t percent) {
  if (percent > 100) return 255;  // unknown
  return percent < 20 ? 10 : percent < 50 ? 35 : percent <= 65 ? 57 : percent < 85 ? 75 : 95;
}

/// The newest tiles of one map, each with the version that it changed at. Its memory is bounded whatever it is given.
///
/// Tiles for the page, gzip, little-endian: "SLMT", version (float64), map id (int32), resolution [m] (float64), side
/// of a tile [cells] (int32), tiles (int32); then for each tile layer (0 both as one, 1 lidar, 2 depth; int32), column,
/// row (int32), and its cells as in map_tile_t, by shadeOf().
class TileStore {
 public:
  static constexpr int kSide = OccupancyGrid::kTileSide;
  static constexpr std::size_t kMostTiles = 3 * 16384;    ///< of all layers: 400 m by 400 m at 5 cm
  static constexpr std::size_t kMostBytes = 64 << 20;     ///< compressed
  static constexpr int kFarthest = 1 << 20;               ///< [tiles] columns and rows beyond are refused
  static constexpr std::size_t kMostCells = 6000 * 6000;  ///< of an image

  /// @return whether the tile says something new. A tile of another map is refused: begin() is first.
  bool put(MapLayer layer, const map_tile_t& tile);
  /// Forgets all tiles where the map is another one.
  void begin(std::int32_t map_id);
  void setResolution(double resolution);  ///< [m]

  std::int32_t mapId() const { return map_id_; }
  double resolution() const { return resolution_; }
  /// Grows with each change.
  std::uint64_t version() const { return version_; }
  std::size_t size() const { return tiles_.size(); }
  std::size_t bytes() const { return bytes_; }

  enum class Wanted : std::uint8_t { kFused, kAllLayers };
  /// Tiles that changed after `version`, as gzip; all of them where there never was such a version.
  std::string changedSince(std::uint64_t version, Wanted wanted = Wanted::kAllLayers) const;
  /// Both layers as one. @return std::nullopt for a map too large to draw
  std::optional<MapImage> image() const;

 private:
  struct Key {
    MapLayer layer;
    int column, row;
    friend auto operator<=>(const Key&, const Key&) = default;
  };
  struct Tile {
    BlockDeflater::Block block;
    std::uint64_t version = 0;
  };

  std::map<Key, Tile> tiles_;
  std::size_t bytes_ = 0;
  std::int32_t map_id_ = 0;
  double resolution_ = OccupancyGridConfig{}.resolution;
  std::uint64_t version_ = 0;
  mutable BlockDeflater deflater_;
};

}  // namespace slam
