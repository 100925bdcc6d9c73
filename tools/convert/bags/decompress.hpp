// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <cstdint>
#include <span>
#include <string_view>
#include <vector>

namespace slam {

inline constexpr std::size_t kLargestChunk = std::size_t{64} << 20;  ///< [bytes] of a chunk, unpacked

/// Unpacks a chunk: "none" or "" (copied), "bz2", "lz4" (frames), "zstd".
/// @param out what could be unpacked, also where the data is damaged or cut off; at most kLargestChunk bytes
/// @return false where not all of it could be, or the compression is none of these
bool decompress(std::string_view compression, std::span<const std::uint8_t> data, std::vector<std::uint8_t>& out);

}  // namespace slam
