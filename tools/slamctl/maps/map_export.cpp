// SPDX-License-Identifier: BSD-3-Clause
#include "tools/slamctl/maps/map_export.hpp"

#include <cerrno>
#include <cstdlib>
#include <system_error>

#include "mapping/map_files.hpp"
#include "store/edit_files.hpp"
#include "store/map_store.hpp"
#include "tools/common/output_file.hpp"
#include "tools/common/trajectory.hpp"
#include "tools/slamctl/maps/map_drawing.hpp"
#include "tools/slamctl/zip_file.hpp"

namespace slam {
namespace {

/// A stored map, drawn to the last keyframe.
struct DrawnExport {
  DrawnExport(const MapExport& of, std::vector<std::string>* remarks)
      : loaded(openMap(of.map, of.grid)), mapper(of.grid) {
    *remarks = loaded.remarks;
    mapper.load(scansOf(loaded.state), viewsOf(loaded.state), loaded.state.grid.clone(), loaded.state.grid_keyframes,
                drawingOf(loaded.state));
    image = renderMap(mapper.grid());
  }

  LoadedMap loaded;
  Mapper mapper;
  MapImage image;
};

/// A folder beside what is written, removed with all in it.
class TemporaryFolder {
 public:
  explicit TemporaryFolder(std::string name) : path_(name += "-XXXXXX") {
    if (::mkdtemp(name.data()) == nullptr)
      throw std::runtime_error(path_ + ": cannot make a folder: " + std::system_category().message(errno));
    path_ = name;
  }
  ~TemporaryFolder() {
    std::error_code ignored;
    std::filesystem::remove_all(path_, ignored);
  }
  TemporaryFolder(const TemporaryFolder&) = delete;
  TemporaryFolder& operator=(const TemporaryFolder&) = delete;
  std::filesystem::path operator/(const std::filesystem::path& name) const { return path_ / name; }

 private:
  std::string path_;
};

void writePath(const std::filesystem::path& file, const MapState& map) {
  TrajectoryWriter out(file);
  for (int id = 0; id < map.keyframes.size(); ++id) {
    if (map.in_map[static_cast<std::size_t>(id)] != 0)
      out.write(toMicroseconds(map.keyframes.scan(id)->stamp), map.keyframes.pose(id));
  }
  out.close();
}

}  // namespace

std::vector<std::string> MapExport::write(std::vector<std::string>* remarks) const {
  prepareMapFiles(prefix);
  const DrawnExport drawn(*this, remarks);
  writeMapFiles(prefix, drawn.image, drawn.mapper.path());
  std::vector<std::string> lines{prefix.string() + ".yaml, .pgm and .png: map of " +
                                 std::to_string(drawn.loaded.state.keyframes.size()) + " keyframes"};
  if (writeEditFiles(prefix, drawn.loaded.state, drawn.image, zones))
    lines.push_back(prefix.string() + ".geojson, -keepout.yaml and .pgm: what was drawn into it");
  return lines;
}

std::vector<std::string> MapExport::writeAll(std::vector<std::string>* remarks) const {
  const std::string name = prefix.filename().string();
  ZipFile zip(prefix.string() + ".zip");
  const TemporaryFolder parts(prefix.string());
  const DrawnExport drawn(*this, remarks);
  const MapState& state = drawn.loaded.state;
  writeMapFiles(parts / name, drawn.image, drawn.mapper.path());
  writeEditFiles(parts / name, state, drawn.image, true);
  writePath(parts / (name + ".tum"), state);
  for (const char* end : {".yaml", ".pgm", ".png", "-keepout.yaml", "-keepout.pgm", ".geojson", ".tum"})
    zip.addFile(name + end, parts / (name + end));
  zip.add(name + ".svg", mapSvg(state, drawn.image, drawn.mapper.path()));
  zip.add(name + ".ply", pointsPly(state));
  zip.close();
  return {prefix.string() + ".zip: map of " + std::to_string(state.keyframes.size()) +
          " keyframes: .yaml, .pgm, .png, -keepout.yaml, -keepout.pgm, .geojson, .svg, .ply and .tum"};
}

}  // namespace slam
