// SPDX-License-Identifier: BSD-3-Clause
#include "tools/web/maps/map_pictures.hpp"

#include <algorithm>
#include <limits>
#include <stdexcept>

#include "mapping/map_image.hpp"
#include "store/map_folders.hpp"
#include "store/map_store.hpp"

namespace slam {
namespace {

namespace fs = std::filesystem;
constexpr int kTile = OccupancyGrid::kTileSide;

struct OnDisk {
  fs::file_time_type written = fs::file_time_type::min();  // its newest file
  std::uintmax_t bytes = 0;
};

OnDisk onDisk(const fs::path& map) {
  OnDisk found;
  std::error_code error;  // what goes meanwhile is not counted
  for (fs::recursive_directory_iterator at(map, error), end; !error && at != end; at.increment(error)) {
    std::error_code gone;
    const auto written = at->last_write_time(gone);
    if (!gone) found.written = std::max(found.written, written);
    const auto bytes = at->is_regular_file(gone) ? at->file_size(gone) : 0;
    if (!gone) found.bytes += bytes;
  }
  return found;
}

/// Visits each cell that something is known of.
template <typename Visit>
void forEachKnown(const OccupancyGrid& grid, const Visit& visit) {
  grid.tiles().forEachTile([&](TileIndex tile, const OccupancyGrid::Tiles::Tile& data) {
    for (int row = 0; row < kTile; ++row) {
      for (int column = 0; column < kTile; ++column) {
        const std::uint8_t value = classify(toProbability(grid.fused(data.at(column, row))));
        if (value != MapImage::kUnknown) visit(tile.column * kTile + column, tile.row * kTile + row, value);
      }
    }
  });
}

}  // namespace

ColourImage smallPicture(const OccupancyGrid& grid, int side) {
  int left = std::numeric_limits<int>::max(), bottom = left, right = std::numeric_limits<int>::min(), top = right;
  forEachKnown(grid, [&](int column, int row, std::uint8_t) {
    left = std::min(left, column), right = std::max(right, column);
    bottom = std::min(bottom, row), top = std::max(top, row);
  });
  MapImage image;
  image.cells = {MapImage::kUnknown};
  image.width = image.height = 1;
  if (left > right) return colourMap(image);
  const int cells = std::max(right - left, top - bottom) / side + 1;  // along a side of a pixel
  image.width = (right - left) / cells + 1, image.height = (top - bottom) / cells + 1;
  image.cells.assign(static_cast<std::size_t>(image.width) * static_cast<std::size_t>(image.height),
                     MapImage::kUnknown);
  forEachKnown(grid, [&](int column, int row, std::uint8_t value) {
    std::uint8_t& pixel = image.at((column - left) / cells, (row - bottom) / cells);
    if (pixel == MapImage::kUnknown || value == MapImage::kOccupied) pixel = value;
  });
  return colourMap(image);
}

std::optional<std::string> MapPictures::nameIn(std::string_view path) {
  constexpr std::string_view kBegin = "/api/v1/maps/", kEnd = ".png";
  if (!path.starts_with(kBegin) || !path.ends_with(kEnd) || path.size() <= kBegin.size() + kEnd.size())
    return std::nullopt;
  std::string name(path.substr(kBegin.size(), path.size() - kBegin.size() - kEnd.size()));
  return MapStore::isName(name) ? std::optional(std::move(name)) : std::nullopt;
}

std::string MapPictures::png(const std::string& name, Timestamp now) const {
  if (folder_.empty()) throw std::runtime_error("slamd stores no maps here; set store.directory");
  struct Asking {
    std::atomic<int>& count;
    ~Asking() { --count; }
  } asking{asking_};
  if (++asking_ > kMostAsking) throw std::runtime_error("too many pictures at once; ask again");
  const std::lock_guard lock(drawing_);
  const OnDisk map = onDisk(mapFolder(folder_, name));
  auto kept = drawn_.find(name);
  if (kept == drawn_.end() || (kept->second.written != map.written && now >= kept->second.at + kAge)) {
    if (kept == drawn_.end() && drawn_.size() >= kMost) {
      drawn_.erase(std::min_element(drawn_.begin(), drawn_.end(),
                                    [](const auto& a, const auto& b) { return a.second.at < b.second.at; }));
    }
    kept = drawn_.insert_or_assign(name, Drawn{{}, {}, now, map.written}).first;
    try {
      kept->second.png = draw(name, map.bytes);
    } catch (const std::runtime_error& error) {
      kept->second.why_not = error.what();
    }
  }
  if (!kept->second.why_not.empty()) throw std::runtime_error(kept->second.why_not);
  return kept->second.png;
}

std::string MapPictures::draw(const std::string& name, std::uintmax_t bytes) const {
  if (bytes > kLargestMap) throw std::runtime_error("map \"" + name + "\" is too large for a small picture");
  return encodePng(smallPicture(MapStore::load(folder_, name, grid_).state.grid, kSide));
}

void MapPictures::forget() const {
  const std::lock_guard lock(drawing_);
  drawn_.clear();
}

}  // namespace slam
