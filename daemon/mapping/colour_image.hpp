// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <cstdint>
#include <string>
#include <vector>

#include "mapping/map_image.hpp"

namespace slam {

struct Rgb {
  std::uint8_t red = 0, green = 0, blue = 0;
  friend bool operator==(const Rgb&, const Rgb&) = default;
};

constexpr Rgb kPathColour{40, 90, 220};

/// A picture for people, row by row from the top.
struct ColourImage {
  int width = 0, height = 0;  ///< [pixels]
  std::vector<Rgb> pixels;    ///< width * height

  const Rgb& at(int column, int row) const {
    return pixels[static_cast<std::size_t>(row) * static_cast<std::size_t>(width) + static_cast<std::size_t>(column)];
  }
  /// Outside the picture: nothing happens.
  void set(int column, int row, Rgb colour) {
    if (column >= 0 && row >= 0 && column < width && row < height) const_cast<Rgb&>(at(column, row)) = colour;
  }
};

/// Occupied black, free white, unknown grey. @param scale [pixels] side of a cell
ColourImage colourMap(const MapImage& map, int scale = 1);

/// Two pictures side by side, the left one first, with a grey gap between; the lower one is filled up with grey.
ColourImage sideBySide(const ColourImage& left, const ColourImage& right);

/// @return the bytes of a PNG file. @throws std::runtime_error when libpng refuses
std::string encodePng(const ColourImage& image);

}  // namespace slam
