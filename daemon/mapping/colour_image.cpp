// SPDX-License-Identifier: BSD-3-Clause
#include "mapping/colour_image.hpp"

#include <png.h>
#include <stdexcept>

namespace slam {

ColourImage colourMap(const MapImage& map, int scale) {
  ColourImage image{.width = map.width * scale, .height = map.height * scale, .pixels = {}};
  image.pixels.reserve(static_cast<std::size_t>(image.width) * static_cast<std::size_t>(image.height));
  for (int row = 0; row < image.height; ++row) {
    for (int column = 0; column < image.width; ++column) {
      const std::uint8_t value = map.at(column / scale, map.height - 1 - row / scale);
      image.pixels.push_back({value, value, value});
    }
  }
  return image;
}

ColourImage sideBySide(const ColourImage& left, const ColourImage& right) {
  constexpr int kGap = 16;  // [pixels]
  constexpr Rgb kGrey{120, 120, 120};
  ColourImage both{left.width + kGap + right.width, std::max(left.height, right.height), {}};
  both.pixels.assign(static_cast<std::size_t>(both.width) * static_cast<std::size_t>(both.height), kGrey);
  const auto paste = [&](const ColourImage& image, int at) {
    for (int row = 0; row < image.height; ++row) {
      for (int column = 0; column < image.width; ++column) both.set(at + column, row, image.at(column, row));
    }
  };
  paste(left, 0);
  paste(right, left.width + kGap);
  return both;
}

std::string encodePng(const ColourImage& image) {
  png_image png{};
  png.version = PNG_IMAGE_VERSION;
  png.width = static_cast<png_uint_32>(image.width);
  png.height = static_cast<png_uint_32>(image.height);
  png.format = PNG_FORMAT_RGB;
  png_alloc_size_t bytes = 0;
  if (!png_image_write_to_memory(&png, nullptr, &bytes, 0, image.pixels.data(), 0, nullptr)) {
    throw std::runtime_error(std::string("png: ") + png.message);
  }
  std::string content(bytes, '\0');
  if (!png_image_write_to_memory(&png, content.data(), &bytes, 0, image.pixels.data(), 0, nullptr)) {
    throw std::runtime_error(std::string("png: ") + png.message);
  }
  content.resize(bytes);
  return content;
}

}  // namespace slam
