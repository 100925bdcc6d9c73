// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <cstdint>
#include <cstring>
#include <random>
#include <slam/map_tile_t.hpp>
#include <stdexcept>
#include <string>
#include <vector>
#include <zlib.h>

#include "tools/web/tile_store.hpp"

// Tiles of a map, and what the page makes of those that it is sent.
namespace slam::test {

/// All unknown.
inline map_tile_t tileAt(std::int32_t map_id, std::int32_t column, std::int32_t row) {
  map_tile_t tile{};
  tile.map_id = map_id;
  tile.column = column;
  tile.row = row;
  tile.side = TileStore::kSide;
  tile.ncells = tile.side * tile.side;
  tile.cells.assign(static_cast<std::size_t>(tile.ncells), 255);
  return tile;
}

inline map_tile_t noisyTile(std::int32_t map_id, std::int32_t column, std::int32_t row, unsigned seed) {
  map_tile_t tile = tileAt(map_id, column, row);
  std::mt19937 random(seed);
  for (auto& cell : tile.cells) cell = static_cast<std::uint8_t>(random() % 101);
  return tile;
}

/// Checks the whole stream, its checksum and its length, too.
inline std::string gunzipped(const std::string& gzip) {
  constexpr int kGzip = 31;  // window bits, with gzip's head
  z_stream stream{};
  if (inflateInit2(&stream, kGzip) != Z_OK) throw std::runtime_error("zlib");
  stream.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(gzip.data()));
  stream.avail_in = static_cast<uInt>(gzip.size());
  std::string text;
  int result = Z_OK;
  while (result == Z_OK) {
    char part[65536];
    stream.next_out = reinterpret_cast<Bytef*>(part);
    stream.avail_out = sizeof part;
    result = inflate(&stream, Z_NO_FLUSH);
    text.append(part, sizeof part - stream.avail_out);
  }
  inflateEnd(&stream);
  if (result != Z_STREAM_END || stream.avail_in != 0) throw std::runtime_error("not one gzip stream");
  return text;
}

template <typename T>
T littleEndian(const std::string& text, std::size_t at) {
  T value{};
  std::memcpy(&value, text.data() + at, sizeof value);
  return value;
}

struct MapHead {
  std::string magic;
  double version, resolution;
  std::int32_t map_id, side, tiles;
};
inline MapHead headIn(const std::string& gzip) {
  const std::string text = gunzipped(gzip);
  return {text.substr(0, 4),
          littleEndian<double>(text, 4),
          littleEndian<double>(text, 16),
          littleEndian<std::int32_t>(text, 12),
          littleEndian<std::int32_t>(text, 24),
          littleEndian<std::int32_t>(text, 28)};
}

struct SentTile {
  std::int32_t layer, column, row;
  std::vector<std::uint8_t> cells;
};
inline std::vector<SentTile> tilesIn(const std::string& gzip) {
  const std::string text = gunzipped(gzip);
  const auto side = static_cast<std::size_t>(littleEndian<std::int32_t>(text, 24));
  std::vector<SentTile> tiles;
  for (std::size_t at = 32; at < text.size(); at += 12 + side * side) {
    const auto* cells = reinterpret_cast<const std::uint8_t*>(text.data()) + at + 12;
    tiles.push_back({littleEndian<std::int32_t>(text, at),
                     littleEndian<std::int32_t>(text, at + 4),
                     littleEndian<std::int32_t>(text, at + 8),
                     {cells, cells + side * side}});
  }
  if (tiles.size() != static_cast<std::size_t>(littleEndian<std::int32_t>(text, 28)))
    throw std::runtime_error("not as many tiles as the head has");
  return tiles;
}

}  // namespace slam::test
