// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <cstdint>
#include <png.h>
#include <stdexcept>
#include <string>
#include <vector>
#include <zlib.h>

/// Pictures as other programs write them.
namespace slam::test {

enum class PngKind {
  kGrey,
  kGrey16,
  kColour,
  kPalette,
  kInterlaced,
  kLinear,  ///< with a gamma of 1
  kBlackAndWhite,
  kGreyOpacity,    ///< of 255, 254 and 0 in turn
  kColourOpacity,  ///< the same
  kGreyKeyed       ///< what is 254 is not there
};

inline void appendTo(png_structp png, png_bytep bytes, std::size_t size) {
  static_cast<std::string*>(png_get_io_ptr(png))->append(reinterpret_cast<char*>(bytes), size);
}

/// A row of a PNG of this kind.
inline std::vector<std::uint8_t> pngRow(const std::uint8_t* greys, int width, PngKind kind) {
  using K = PngKind;
  std::vector<std::uint8_t> row;
  for (int i = 0; i < width; ++i) {
    constexpr std::uint8_t kOpacities[] = {255, 254, 0};
    const bool colour = kind == K::kColour || kind == K::kColourOpacity;
    row.insert(row.end(), colour ? 3 : kind == K::kGrey16 ? 2 : 1, greys[i]);
    if (kind == K::kGreyOpacity || kind == K::kColourOpacity) row.push_back(kOpacities[i % 3]);
    if (kind != K::kBlackAndWhite) continue;
    row.pop_back();
    if (i % 8 == 0) row.push_back(0);
    if (greys[i] != 0) row.back() = static_cast<std::uint8_t>(row.back() | 0x80 >> i % 8);
  }
  return row;
}

/// @param greys of width * height pixels, the upper row first
inline std::string png(int width, int height, const std::vector<std::uint8_t>& greys, PngKind kind) {
  using K = PngKind;
  std::string content;
  png_structp png = png_create_write_struct(PNG_LIBPNG_VER_STRING, nullptr, nullptr, nullptr);
  png_infop info = png_create_info_struct(png);
  png_set_write_fn(png, &content, appendTo, nullptr);
  const int type = kind == K::kColour          ? PNG_COLOR_TYPE_RGB
                   : kind == K::kColourOpacity ? PNG_COLOR_TYPE_RGB_ALPHA
                   : kind == K::kGreyOpacity   ? PNG_COLOR_TYPE_GRAY_ALPHA
                   : kind == K::kPalette       ? PNG_COLOR_TYPE_PALETTE
                                               : PNG_COLOR_TYPE_GRAY;
  png_set_IHDR(png, info, static_cast<png_uint_32>(width), static_cast<png_uint_32>(height),
               kind == K::kGrey16          ? 16
               : kind == K::kBlackAndWhite ? 1
                                           : 8,
               type, kind == K::kInterlaced ? PNG_INTERLACE_ADAM7 : PNG_INTERLACE_NONE, PNG_COMPRESSION_TYPE_DEFAULT,
               PNG_FILTER_TYPE_DEFAULT);
  std::vector<png_color> palette;
  for (int i = 0; i < 256; ++i) palette.push_back({png_byte(i), png_byte(i), png_byte(i)});
  if (kind == K::kPalette) png_set_PLTE(png, info, palette.data(), 256);
  if (kind == K::kLinear) png_set_gAMA(png, info, 1.0);
  const png_color_16 key{.index = 0, .red = 0, .green = 0, .blue = 0, .gray = 254};
  if (kind == K::kGreyKeyed) png_set_tRNS(png, info, nullptr, 0, &key);
  std::vector<std::vector<std::uint8_t>> rows;
  std::vector<png_bytep> pointers;
  for (int row = 0; row < height; ++row)
    rows.push_back(pngRow(greys.data() + static_cast<std::size_t>(row) * static_cast<std::size_t>(width), width, kind));
  for (auto& row : rows) pointers.push_back(row.data());
  png_write_info(png, info);
  png_write_image(png, pointers.data());
  png_write_end(png, nullptr);
  png_destroy_write_struct(&png, &info);
  return content;
}

/// The beginning of a PNG, and no pixel of it.
inline std::string pngHeader(std::uint32_t width, std::uint32_t height) {
  std::string header("\x89PNG\r\n\x1A\n\0\0\0\rIHDR", 16);
  const auto put = [&](std::uint32_t value) {
    for (int shift = 24; shift >= 0; shift -= 8) header.push_back(static_cast<char>(value >> shift));
  };
  put(width);
  put(height);
  header.append("\x08\0\0\0\0", 5);
  put(static_cast<std::uint32_t>(crc32(0, reinterpret_cast<const Bytef*>(header.data()) + 12, 17)));
  return header + std::string("\0\0\0\0IDAT\x35\xAF\x06\x1E", 12);
}

}  // namespace slam::test
