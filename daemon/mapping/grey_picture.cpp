// SPDX-License-Identifier: BSD-3-Clause
#include "mapping/grey_picture.hpp"

#include <algorithm>
#include <cerrno>
#include <csetjmp>
#include <cstdio>
#include <cstring>
#include <png.h>
#include <stdexcept>
#include <string>

#include "core/plausibility.hpp"

namespace slam {
namespace {

namespace fs = std::filesystem;

/// @param least [bytes] that so many pixels take in the file
std::size_t pixelsOf(const fs::path& file, const GreyPicture& picture, double least, std::uintmax_t size) {
  if (const std::string words = implausibilityOfSize(picture.width, picture.height); !words.empty())
    refuseFile(file, words + "; the map is not read; cut off what is not known around it");
  if (least > static_cast<double>(size)) refuseFile(file, "shorter than its header says");
  return static_cast<std::size_t>(picture.width) * static_cast<std::size_t>(picture.height);
}

/// A number of a PGM, behind blanks and comments; 1e9 stands for all above. @param left [bytes] that may still be read
/// @return -1 where none stands
int nextNumber(std::streambuf& in, std::size_t& left) {
  bool comment = false;
  int number = -1;
  for (; left > 0; --left) {
    const int c = in.sgetc();
    if (number < 0 && c > 0 && (comment || c == '#')) {
      comment = c != '\n' && c != '\r';
    } else if (c >= '0' && c <= '9') {
      number = static_cast<int>(std::min(10LL * std::max(number, 0) + (c - '0'), 1'000'000'000LL));
    } else if (number >= 0 || c <= 0 || std::strchr(" \t\r\n\v\f", c) == nullptr) {
      return number;  // in front of what ends it
    }
    in.sbumpc();
  }
  return -1;
}

void readText(const fs::path& file, std::streambuf& in, int greatest, GreyPicture& picture) {
  std::size_t left = 16 * picture.greys.size() + static_cast<std::size_t>(kPlausible.text_bytes);
  for (std::uint8_t& grey : picture.greys) {
    const int value = nextNumber(in, left);
    if (value < 0 && left == 0) refuseFile(file, "has more blanks and comments than a picture needs");
    if (value < 0 && in.sgetc() == std::streambuf::traits_type::eof()) refuseFile(file, "shorter than its header says");
    if (value < 0 || value > greatest) refuseFile(file, "has a value that is no number from 0 to its greatest value");
    grey = static_cast<std::uint8_t>((value * 255 + greatest / 2) / greatest);
  }
}

void readBinary(const fs::path& file, std::istream& in, int greatest, GreyPicture& picture) {
  const std::size_t bytes = greatest > 255 ? 2 : 1, width = static_cast<std::size_t>(picture.width);
  std::vector<std::uint8_t> row(width * bytes);
  for (std::size_t at = 0; at < picture.greys.size(); ++at) {
    const std::size_t column = at % width;
    if (column == 0 && !in.read(reinterpret_cast<char*>(row.data()), static_cast<std::streamsize>(row.size())))
      refuseFile(file, "shorter than its header says");
    const int value = bytes == 1 ? row[column] : row[2 * column] << 8 | row[2 * column + 1];
    if (value > greatest) refuseFile(file, "has a value above the greatest one of its header");
    picture.greys[at] = static_cast<std::uint8_t>((value * 255 + greatest / 2) / greatest);
  }
}

GreyPicture readPgm(const fs::path& file, std::ifstream& in, bool binary, std::uintmax_t size) {
  std::streambuf& bytes = *in.rdbuf();
  std::size_t left = static_cast<std::size_t>(kPlausible.text_bytes);
  GreyPicture picture;
  picture.width = nextNumber(bytes, left);
  picture.height = nextNumber(bytes, left);
  const int greatest = nextNumber(bytes, left);
  if (greatest <= 0 || greatest > 65535)
    refuseFile(file, "its header is not that of a PGM: width, height, and the greatest value, of 1 to 65535");
  bytes.sbumpc();  // one blank
  const double least = static_cast<double>(picture.width) * picture.height * (binary && greatest < 256 ? 1.0 : 2.0);
  picture.greys.resize(pixelsOf(file, picture, binary ? least : least - 1.0, size));
  binary ? readBinary(file, in, greatest, picture) : readText(file, bytes, greatest, picture);
  return picture;
}

/// libpng's state, and what went wrong.
struct PngReader {
  explicit PngReader(std::istream& stream) : in(stream) {}
  ~PngReader() { png_destroy_read_struct(&png, &info, nullptr); }
  PngReader(const PngReader&) = delete;
  PngReader& operator=(const PngReader&) = delete;

  static void keepError(png_structp png, png_const_charp words) {
    auto& self = *static_cast<PngReader*>(png_get_error_ptr(png));
    std::snprintf(self.error, sizeof self.error, "%s", words);
    png_longjmp(png, 1);
  }
  static void read(png_structp png, png_bytep bytes, std::size_t size) {
    auto& self = *static_cast<PngReader*>(png_get_io_ptr(png));
    if (!self.in.read(reinterpret_cast<char*>(bytes), static_cast<std::streamsize>(size)))
      png_error(png, "shorter than its header says");
  }

  std::istream& in;
  png_structp png = png_create_read_struct(PNG_LIBPNG_VER_STRING, this, keepError, [](png_structp, png_const_charp) {});
  png_infop info = png_create_info_struct(png);
  char error[128] = "";
};

/// Reads what stands in front of the pixels. No object of this function and the next one may have a destructor: libpng
/// jumps out of them. @return false with the reason in the reader
bool readHeader(PngReader& reader) {
  if (setjmp(png_jmpbuf(reader.png)) != 0) return false;
  png_set_read_fn(reader.png, &reader, PngReader::read);
  png_set_user_limits(reader.png, 0x7fffffff, 0x7fffffff);  // the pixels are limited, not each side
  png_set_keep_unknown_chunks(reader.png, PNG_HANDLE_CHUNK_NEVER, nullptr, 0);
  png_read_info(reader.png, reader.info);
  return true;
}

/// @param row_bytes [bytes] of each row: a grey, or a grey and an opacity, of 8 bits each
bool readRows(PngReader& reader, std::size_t row_bytes, png_bytepp rows) {
  png_structp png = reader.png;
  if (setjmp(png_jmpbuf(png)) != 0) return false;
  png_set_expand(png);
  png_set_scale_16(png);
  png_set_rgb_to_gray_fixed(png, PNG_ERROR_ACTION_NONE, PNG_RGB_TO_GRAY_DEFAULT, PNG_RGB_TO_GRAY_DEFAULT);
  png_set_interlace_handling(png);
  png_read_update_info(png, reader.info);
  if (png_get_rowbytes(png, reader.info) != row_bytes) png_error(png, "of an unknown kind");
  png_read_image(png, rows);
  png_read_end(png, nullptr);
  return true;
}

GreyPicture readPng(const fs::path& file, std::ifstream& in, std::uintmax_t size) {
  PngReader reader(in);
  if (reader.info == nullptr) throw std::bad_alloc();
  if (!readHeader(reader)) refuseFile(file, std::string("damaged PNG: ") + reader.error);
  GreyPicture picture;
  picture.width = static_cast<int>(png_get_image_width(reader.png, reader.info));
  picture.height = static_cast<int>(png_get_image_height(reader.png, reader.info));
  // Deflate makes at most 1032 bytes of one.
  const double row_bytes = static_cast<double>(png_get_rowbytes(reader.png, reader.info));
  const std::size_t pixels = pixelsOf(file, picture, row_bytes * picture.height / 1032.0, size);
  const bool opaque = (png_get_color_type(reader.png, reader.info) & PNG_COLOR_MASK_ALPHA) == 0 &&
                      png_get_valid(reader.png, reader.info, PNG_INFO_tRNS) == 0;
  const std::size_t row = static_cast<std::size_t>(picture.width) * (opaque ? 1 : 2);
  picture.greys.resize(pixels * (opaque ? 1 : 2));
  std::vector<png_bytep> rows;
  for (int i = 0; i < picture.height; ++i) rows.push_back(picture.greys.data() + row * static_cast<std::size_t>(i));
  if (!readRows(reader, row, rows.data())) refuseFile(file, std::string("damaged PNG: ") + reader.error);
  if (opaque) return picture;
  picture.see_through.resize(pixels);
  for (std::size_t i = 0; i < pixels; ++i) {
    picture.see_through[i] = picture.greys[2 * i + 1] != 255;
    picture.greys[i] = picture.greys[2 * i];
  }
  picture.greys.resize(pixels);
  return picture;
}

}  // namespace

std::uintmax_t openToRead(const fs::path& file, std::ifstream& in) {
  std::error_code error;
  const fs::file_status status = fs::status(file, error);
  if (fs::exists(status) && !fs::is_regular_file(status)) refuseFile(file, "cannot read: it is no file");
  in.open(file, std::ios::binary);
  if (!in) refuseFile(file, std::string("cannot read: ") + std::strerror(errno));
  return fs::file_size(file);
}

void refuseFile(const fs::path& file, const std::string& what) {
  throw std::runtime_error(file.string() + ": " + what);
}

GreyPicture readGreyPicture(const fs::path& file) {
  std::ifstream in;
  const std::uintmax_t size = openToRead(file, in);
  char begin[8] = {};
  in.read(begin, 2);
  const std::string_view pgm(begin, 2);
  if (pgm == "P5" || pgm == "P2") return readPgm(file, in, pgm == "P5", size);
  in.clear();
  in.seekg(0);
  in.read(begin, sizeof begin);
  if (std::memcmp(begin, "\x89PNG\r\n\x1A\n", sizeof begin) != 0)
    refuseFile(file, "neither PNG nor PGM (P5, P2), the only pictures of a map that slamd reads; convert it to PNG");
  in.seekg(0);
  return readPng(file, in, size);
}

}  // namespace slam
