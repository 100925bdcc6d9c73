// SPDX-License-Identifier: BSD-3-Clause
#include "store/edit_files.hpp"

#include <algorithm>

#include "mapping/map_files.hpp"
#include "slam/edits/edit_export.hpp"

namespace slam {

bool writeEditFiles(const std::filesystem::path& prefix, const MapState& map, const MapImage& image, bool always) {
  const auto& edits = map.edits.edits;
  if (!always && std::none_of(edits.begin(), edits.end(), [](const MapEdit& edit) { return edit.active; }))
    return false;
  const MapImage mask = keepOutMask(map, image);
  const std::string keepout = prefix.string() + "-keepout";
  replaceFile(keepout + ".pgm", encodePgm(mask));
  replaceFile(keepout + ".yaml", encodeYaml(prefix.filename().string() + "-keepout.pgm", mask));
  replaceFile(prefix.string() + ".geojson", editsGeoJson(map));
  return true;
}

}  // namespace slam
