// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <atomic>
#include <filesystem>
#include <map>
#include <mutex>
#include <optional>
#include <string>
#include <string_view>

#include "core/timestamp.hpp"
#include "mapping/colour_image.hpp"
#include "mapping/occupancy_grid.hpp"

namespace slam {

/// A map as a small picture, of `side` pixels at most: a pixel is occupied where any of its cells is. Transparency has
/// none: what is unknown is grey. Nothing known: one pixel.
ColourImage smallPicture(const OccupancyGrid& grid, int side);

/// Small pictures of stored maps. Each is drawn when somebody asks, one at a time, and kept while the map on the disk
/// stays as it is. Safe from several threads.
class MapPictures {
 public:
  static constexpr int kSide = 240;                           ///< [pixels]
  static constexpr std::size_t kMost = 64;                    ///< that are kept: some MB
  static constexpr Duration kAge = std::chrono::seconds(10);  ///< of one whose map slamd writes
  static constexpr int kMostAsking = 8;                       ///< threads that may wait for the one that draws
  static constexpr std::uintmax_t kLargestMap = 200'000'000;  ///< [bytes] of its files: it is loaded whole

  /// @param folder of all maps; empty: there is none
  MapPictures(std::filesystem::path folder, const OccupancyGridConfig& grid)
      : folder_(std::move(folder)), grid_(grid) {}

  /// The name in /api/v1/maps/NAME.png; std::nullopt for any other path.
  static std::optional<std::string> nameIn(std::string_view path);
  /// @return a PNG file @throws std::runtime_error where there is no such map, or it cannot be drawn
  std::string png(const std::string& name, Timestamp now) const;
  /// Maps have other names now.
  void forget() const;

 private:
  struct Drawn {
    std::string png, why_not;  // one of them is empty
    Timestamp at;
    std::filesystem::file_time_type written;
  };
  std::filesystem::path folder_;
  OccupancyGridConfig grid_;
  std::string draw(const std::string& name, std::uintmax_t bytes) const;

  mutable std::atomic<int> asking_{0};
  mutable std::mutex drawing_;
  mutable std::map<std::string, Drawn> drawn_;
};

}  // namespace slam
