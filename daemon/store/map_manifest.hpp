// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <cstdint>
#include <map>
#include <stdexcept>
#include <string>
#include <string_view>

namespace slam {

/// A map that a newer slamd has written: to be left alone, not to be gone behind.
struct NewerMap : std::runtime_error {
  NewerMap(const std::string& words, std::int64_t order_written) : std::runtime_error(words), order(order_written) {}
  std::int64_t order;  ///< as of the manifest
};

/// The edits of a map: a generation that has them is of format 2, which older programs leave alone.
inline constexpr const char* kEditsFile = "edits.bin";

/// What a generation of a stored map consists of.
struct MapManifest {
  struct File {
    std::size_t size = 0;  ///< [bytes]
    std::uint32_t crc = 0;
    friend bool operator==(const File&, const File&) = default;
  };
  std::int64_t utime = 0;  ///< [us] of the map's last pose
  /// The map with the highest one in a store was gone on in last, whatever the clocks said; 0: a copy that nobody has
  /// gone on in, or a map of a slamd that counted none.
  std::int64_t order = 0;
  int keyframes = 0;
  std::map<std::string, File> files;  ///< by name
  friend bool operator==(const MapManifest&, const MapManifest&) = default;
};

/// As lines of text; the last one is the CRC-32 of those before it, in this format's every version.
std::string encodeManifest(const MapManifest& manifest);
/// Believes nothing of it, the version least of all, before the CRC is right.
/// @throws NewerMap where it is intact and of a newer format, std::runtime_error where it is damaged
MapManifest decodeManifest(std::string_view text);

}  // namespace slam
