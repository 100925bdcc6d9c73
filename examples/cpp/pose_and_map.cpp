// SPDX-License-Identifier: BSD-3-Clause
// Prints slamd's pose twice a second, and keeps its map as a picture (PGM: dark walls, light free space, grey unknown).
// Usage: pose_and_map [MAP.pgm]
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <lcm/lcm-cpp.hpp>
#include <map>
#include <slam/map_meta_t.hpp>
#include <slam/map_tile_t.hpp>
#include <slam/pose_estimate_t.hpp>
#include <string>
#include <utility>
#include <vector>

namespace {

constexpr std::int64_t kPeriod = 500000;  // [us] between printed poses
constexpr unsigned char kUnknown = 128;   // grey

class Reader {
 public:
  explicit Reader(std::string path) : path_(std::move(path)) {}

  void onPose(const lcm::ReceiveBuffer*, const std::string&, const slam::pose_estimate_t* pose) {
    constexpr const char* kStates[] = {"initialising", "localised", "degraded", "lost"};
    if (std::abs(pose->utime - printed_) < kPeriod) return;
    printed_ = pose->utime;
    const double sigma = std::sqrt(std::max(pose->covariance[0], pose->covariance[4]));
    std::printf("%s: x %.3f m, y %.3f m, theta %.3f rad, sigma %.3f m\n",
                pose->state < 4 ? kStates[pose->state] : "unknown", pose->x, pose->y, pose->theta, sigma);
    std::fflush(stdout);
  }
  void onTile(const lcm::ReceiveBuffer*, const std::string&, const slam::map_tile_t* tile) {
    begin(tile->map_id);
    if (tile->ncells == tile->side * tile->side) tiles_[{tile->column, tile->row}] = *tile;
  }
  void onMeta(const lcm::ReceiveBuffer*, const std::string&, const slam::map_meta_t* meta) {
    begin(meta->map_id);
    if (meta->tiles > 0 && !tiles_.empty() && !path_.empty()) write(*meta);
  }

 private:
  /// Tiles of the last map are none of another that has begun.
  void begin(int map_id) {
    if (std::exchange(map_id_, map_id) != map_id) tiles_.clear();
  }
  /// Joins the tiles. Row 0 of a picture is at its top, row 0 of the map at its bottom.
  void write(const slam::map_meta_t& meta) const {
    const int side = meta.tile_side;
    const int width = (meta.column_max - meta.column_min + 1) * side, height = (meta.row_max - meta.row_min + 1) * side;
    std::vector<unsigned char> picture(static_cast<std::size_t>(width) * static_cast<std::size_t>(height), kUnknown);
    for (const auto& [place, tile] : tiles_) {
      const auto [column, row] = place;
      const bool inside = column >= meta.column_min && column <= meta.column_max && row >= meta.row_min &&
                          row <= meta.row_max && tile.side == side;
      if (!inside) continue;  // came after the map grew, before its new geometry
      for (int line = 0; line < side; ++line) {
        const int top = (meta.row_max - row) * side + side - 1 - line;
        const auto* cells = tile.cells.data() + line * side;
        std::transform(cells, cells + side, picture.begin() + top * width + (column - meta.column_min) * side,
                       [](std::uint8_t cell) {
                         return cell == 255 ? kUnknown
                                            : static_cast<unsigned char>(255 - 255 * std::min<int>(cell, 100) / 100);
                       });
      }
    }
    const std::string draft = path_ + ".new";  // whoever shows the picture never sees half of it
    std::FILE* file = std::fopen(draft.c_str(), "wb");
    if (file == nullptr) {
      std::perror(draft.c_str());
      std::exit(1);
    }
    std::fprintf(file, "P5\n%d %d\n255\n", width, height);
    const bool whole = std::fwrite(picture.data(), 1, picture.size(), file) == picture.size();
    if ((std::fclose(file) != 0) || !whole || std::rename(draft.c_str(), path_.c_str()) != 0) {
      std::perror(path_.c_str());
      std::exit(1);
    }
  }

  std::string path_;
  std::int64_t printed_ = 0;
  int map_id_ = 0;
  std::map<std::pair<int, int>, slam::map_tile_t> tiles_;
};

}  // namespace

int main(int argc, char** argv) {
  lcm::LCM lcm;  // LCM_DEFAULT_URL, or this computer alone
  if (!lcm.good()) {
    std::fprintf(stderr, "LCM cannot open its socket: is there a multicast route (ip route add 224.0.0.0/4 dev lo)?\n");
    return 1;
  }
  Reader reader(argc > 1 ? argv[1] : "");
  lcm.subscribe("SLAM_POSE", &Reader::onPose, &reader);
  lcm.subscribe("SLAM_MAP_TILE", &Reader::onTile, &reader);
  lcm.subscribe("SLAM_MAP_META", &Reader::onMeta, &reader);
  while (lcm.handle() == 0) {
  }
  return 1;
}
