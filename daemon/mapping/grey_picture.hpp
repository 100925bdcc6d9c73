// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

namespace slam {

/// A picture in 256 greys, row by row from the top.
struct GreyPicture {
  int width = 0, height = 0;        ///< [pixels]
  std::vector<std::uint8_t> greys;  ///< width * height
  std::vector<bool> see_through;    ///< the same, of pixels that are not opaque; empty: all are
};

/// Reads a PNG of any kind, or a PGM: binary (P5) or as text (P2), of 8 bits or 16. Colours become their brightness. Of
/// the file no more is read than its header says, and not more pixels than PlausibilityLimits allow.
/// @throws std::runtime_error with file and reason
GreyPicture readGreyPicture(const std::filesystem::path& file);

/// @throws std::runtime_error with file and reason
[[noreturn]] void refuseFile(const std::filesystem::path& file, const std::string& what);

/// Opens a file for reading. What is no file, as a pipe, is refused and not waited for.
/// @return its size [bytes] @throws std::runtime_error with file and reason
std::uintmax_t openToRead(const std::filesystem::path& file, std::ifstream& in);

}  // namespace slam
