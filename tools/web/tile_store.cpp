// SPDX-License-Identifier: BSD-3-Clause
#include "tools/web/tile_store.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <stdexcept>
#include <vector>
#include <zlib.h>

#include "core/plausibility.hpp"

namespace slam {
namespace {

using Bytes = std::vector<std::uint8_t>;
constexpr int kRaw = -15;  // window bits of a deflate stream without header
constexpr std::uint8_t kUnknown = 255;
constexpr std::size_t kTileHead = 12;  // [bytes] layer, column, row

template <typename T>
void put(Bytes& bytes, T value) {  // little-endian, as every computer that slamd runs on
  const auto* begin = reinterpret_cast<const std::uint8_t*>(&value);
  bytes.insert(bytes.end(), begin, begin + sizeof value);
}

void putLittleEndian(std::string& text, std::uint32_t value) {
  for (int shift = 0; shift < 32; shift += 8) text += static_cast<char>(value >> shift);
}

std::vector<std::uint8_t> inflated(const BlockDeflater::Block& block) {
  std::vector<std::uint8_t> bytes(block.size);
  z_stream stream{};
  if (inflateInit2(&stream, kRaw) != Z_OK) throw std::runtime_error("zlib refuses to inflate");
  stream.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(block.deflated.data()));
  stream.avail_in = static_cast<uInt>(block.deflated.size());
  stream.next_out = bytes.data();
  stream.avail_out = static_cast<uInt>(bytes.size());
  inflate(&stream, Z_SYNC_FLUSH);
  inflateEnd(&stream);
  return bytes;
}

}  // namespace

struct BlockDeflater::Stream {
  z_stream z{};
};

BlockDeflater::BlockDeflater() : stream_(std::make_unique<Stream>()) {
  if (deflateInit2(&stream_->z, Z_DEFAULT_COMPRESSION, Z_DEFLATED, kRaw, 8, Z_DEFAULT_STRATEGY) != Z_OK)
    throw std::runtime_error("zlib refuses to deflate");
}

BlockDeflater::~BlockDeflater() { deflateEnd(&stream_->z); }

BlockDeflater::Block BlockDeflater::compress(std::span<const std::uint8_t> bytes) {
  Block block;
  block.size = bytes.size();
  block.checksum = static_cast<std::uint32_t>(crc32(0, bytes.data(), static_cast<uInt>(bytes.size())));
  z_stream& z = stream_->z;
  deflateReset(&z);
  constexpr std::size_t kFlush = 16;  // [bytes] that a flush adds at most
  block.deflated.resize(deflateBound(&z, static_cast<uLong>(bytes.size())) + kFlush);
  z.next_in = const_cast<Bytef*>(bytes.data());
  z.avail_in = static_cast<uInt>(bytes.size());
  z.next_out = reinterpret_cast<Bytef*>(block.deflated.data());
  z.avail_out = static_cast<uInt>(block.deflated.size());
  deflate(&z, Z_FULL_FLUSH);  // ends on a whole byte, and leaves nothing that the next block could refer to
  block.deflated.resize(block.deflated.size() - z.avail_out);
  block.deflated.shrink_to_fit();
  return block;
}

void TileStore::begin(std::int32_t map_id) {
  if (map_id == map_id_) return;
  map_id_ = map_id;
  tiles_.clear();
  bytes_ = 0;
  ++version_;
}

void TileStore::setResolution(double resolution) {
  if (!implausibilityOfResolution(resolution).empty() || resolution == resolution_) return;
  resolution_ = resolution;
  ++version_;
}

bool TileStore::put(MapLayer layer, const map_tile_t& message) {
  const bool sound = message.side == kSide && message.cells.size() == static_cast<std::size_t>(kSide) * kSide &&
                     std::abs(static_cast<std::int64_t>(message.column)) <= kFarthest &&
                     std::abs(static_cast<std::int64_t>(message.row)) <= kFarthest;
  if (!sound || message.map_id != map_id_) return false;
  Bytes bytes;
  bytes.reserve(kTileHead + message.cells.size());
  slam::put(bytes, static_cast<std::int32_t>(layer));
  slam::put(bytes, message.column);
  slam::put(bytes, message.row);
  for (const auto cell : message.cells) bytes.push_back(shadeOf(static_cast<std::uint8_t>(cell)));

  const Key key{layer, message.column, message.row};
  const auto known = tiles_.find(key);
  const auto checksum = static_cast<std::uint32_t>(crc32(0, bytes.data(), static_cast<uInt>(bytes.size())));
  if (known != tiles_.end() && known->second.block.checksum == checksum) return false;
  if (known == tiles_.end() && (tiles_.size() >= kMostTiles || bytes_ >= kMostBytes)) return false;
  Tile& tile = tiles_[key];
  bytes_ -= tile.block.deflated.size();
  tile.block = deflater_.compress(bytes);
  bytes_ += tile.block.deflated.size();
  tile.version = ++version_;
  return true;
}

std::string TileStore::changedSince(std::uint64_t version, Wanted wanted) const {
  if (version > version_) version = 0;
  std::vector<const Tile*> changed;
  std::size_t size = 0;
  for (const auto& [key, tile] : tiles_) {
    if (tile.version <= version || (wanted == Wanted::kFused && key.layer != MapLayer::kBoth)) continue;
    changed.push_back(&tile);
    size += tile.block.deflated.size();
  }
  Bytes head{'S', 'L', 'M', 'T'};
  slam::put(head, static_cast<double>(version_));
  slam::put(head, map_id_);
  slam::put(head, resolution_);
  slam::put(head, static_cast<std::int32_t>(kSide));
  slam::put(head, static_cast<std::int32_t>(changed.size()));
  const BlockDeflater::Block first = deflater_.compress(head);

  const char kGzipHead[] = {'\x1f', '\x8b', 8, 0, 0, 0, 0, 0, 0, '\xff'};
  const char kLastBlock[] = {3, 0};  // empty, and marked as the last
  std::string gzip(std::begin(kGzipHead), std::end(kGzipHead));
  gzip.reserve(gzip.size() + first.deflated.size() + size + 16);
  gzip += first.deflated;
  uLong checksum = first.checksum;
  std::size_t length = first.size;
  for (const Tile* tile : changed) {
    gzip += tile->block.deflated;
    checksum = crc32_combine(checksum, tile->block.checksum, static_cast<z_off_t>(tile->block.size));
    length += tile->block.size;
  }
  gzip.append(std::begin(kLastBlock), std::end(kLastBlock));
  putLittleEndian(gzip, static_cast<std::uint32_t>(checksum));
  putLittleEndian(gzip, static_cast<std::uint32_t>(length));
  return gzip;
}

std::optional<MapImage> TileStore::image() const {
  MapImage image;
  image.resolution = resolution_;
  image.width = image.height = 1;
  int left = kFarthest, bottom = kFarthest, right = -kFarthest, top = -kFarthest;  // [tiles]
  for (const auto& [key, tile] : tiles_) {
    if (key.layer != MapLayer::kBoth) continue;
    left = std::min(left, key.column), right = std::max(right, key.column);
    bottom = std::min(bottom, key.row), top = std::max(top, key.row);
  }
  if (left <= right) {
    image.width = (right - left + 1) * kSide;
    image.height = (top - bottom + 1) * kSide;
    image.origin_x = left * kSide * resolution_;
    image.origin_y = bottom * kSide * resolution_;
  }
  const std::size_t cells = static_cast<std::size_t>(image.width) * static_cast<std::size_t>(image.height);
  if (cells > kMostCells) return std::nullopt;
  image.cells.assign(cells, MapImage::kUnknown);
  for (const auto& [key, tile] : tiles_) {
    if (key.layer != MapLayer::kBoth) continue;
    const Bytes bytes = inflated(tile.block);
    for (int row = 0; row < kSide; ++row) {
      for (int column = 0; column < kSide; ++column) {
        const std::uint8_t percent = bytes[kTileHead + static_cast<std::size_t>(row * kSide + column)];
        if (percent == kUnknown) continue;
        image.at((key.column - left) * kSide + column, (key.row - bottom) * kSide + row) = classify(percent / 100.0);
      }
    }
  }
  return image;
}

}  // namespace slam
