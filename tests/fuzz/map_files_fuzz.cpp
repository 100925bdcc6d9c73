// SPDX-License-Identifier: BSD-3-Clause
// The input is the length of a map_server .yaml, that .yaml and a PGM or PNG: a floor plan that somebody gives. What is
// read is made a map, as slamd does before it localises in it.
#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>

#include "core/plausibility.hpp"
#include "fuzz/fuzzing.hpp"
#include "fuzz/memory_file.hpp"
#include "mapping/map_files.hpp"
#include "slam/map_import.hpp"

namespace slam {
namespace {

using fuzz::textOf;

/// But for the last two bits, which are no digits of what is written.
bool isSame(double read, double written) { return std::abs(read - written) <= 1e-15 * std::abs(written); }

/// What is written of an image and read again is the same image.
void checkWritten(const MapImage& image, const fuzz::MemoryFile& yaml, const fuzz::MemoryFile& pgm) {
  yaml.write(encodeYaml(pgm.path().filename(), image));
  pgm.write(encodePgm(image));
  const MapImage again = readMapFiles(yaml.path());
  FUZZ_CHECK(again.width == image.width && again.height == image.height && again.cells == image.cells);
  FUZZ_CHECK(isSame(again.resolution, image.resolution));
  FUZZ_CHECK(isSame(again.origin_x, image.origin_x) && isSame(again.origin_y, image.origin_y));
}

std::size_t knownCells(const MapImage& image) {
  return image.cells.size() -
         static_cast<std::size_t>(std::count(image.cells.begin(), image.cells.end(), MapImage::kUnknown));
}

void checkMap(const MapImage& image) {
  const std::size_t known = knownCells(image);
  std::size_t found = 0;
  const MapState map = importMap(image);
  FUZZ_CHECK(map.in_map.size() == static_cast<std::size_t>(map.keyframes.size()));
  FUZZ_CHECK(map.grid_keyframes == map.keyframes.size());
  for (int id = 0; id < map.keyframes.size(); ++id) {
    const StoredScan& scan = *map.keyframes.scan(id);
    found += scan.points.size() + scan.free.size() + scan.solid.size();
  }
  FUZZ_CHECK(found == known);
}

}  // namespace
}  // namespace slam

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace slam;
  static const fuzz::MemoryFile yaml, pgm;
  fuzz::Input input({data, size});
  const auto length = input.take<std::uint16_t>();
  // Which file is the picture is not left to the input.
  yaml.write("image: " + pgm.path().filename().string() + "\n" + textOf(input.takeBytes(length)));
  const std::string picture = textOf(input.rest());
  pgm.write(picture);
  MapImage image;
  try {
    image = readMapFiles(yaml.path());
  } catch (const std::runtime_error&) {  // refused
    return 0;
  }
  FUZZ_CHECK(image.width > 0 && image.height > 0);
  FUZZ_CHECK(image.cells.size() == static_cast<std::size_t>(image.width) * static_cast<std::size_t>(image.height));
  FUZZ_CHECK(image.cells.size() <= static_cast<std::size_t>(kPlausible.picture_cells));
  // A pixel takes a byte of a PGM, and lies in four cells at most where it is turned.
  if (picture.front() == 'P') FUZZ_CHECK(knownCells(image) <= 4 * picture.size());
  for (const std::uint8_t cell : image.cells) {
    FUZZ_CHECK(cell == MapImage::kFree || cell == MapImage::kOccupied || cell == MapImage::kUnknown);
  }
  FUZZ_CHECK_NO_THROW((checkWritten(image, yaml, pgm), true));
  FUZZ_CHECK_NO_THROW((checkMap(image), true));
  return 0;
}
