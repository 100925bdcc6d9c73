// SPDX-License-Identifier: BSD-3-Clause
#include "store/map_codec.hpp"

#include <algorithm>
#include <array>
#include <climits>
#include <cmath>
#include <cstring>
#include <iomanip>
#include <limits>
#include <sstream>
#include <toml++/toml.h>
#include <utility>
#include <vector>
#include <zlib.h>

#include "core/plausibility.hpp"

namespace slam {
namespace {

constexpr std::size_t kNodeBytes = 65, kPointBytes = 12, kEdgeBytes = 82;  // at least
constexpr std::size_t kViewBytes = 76, kBeamBytes = 13, kSurfaceBytes = 12;
constexpr std::size_t kTileCells = OccupancyGrid::kTileSide * OccupancyGrid::kTileSide;
constexpr std::size_t kTileBytes = 8 + 2 * kTileCells;
constexpr std::uint64_t kMostPacked = 1100;  // [1] no more than so many times is anything compressed by deflate

// What a map may hold. Writing asks the same functions as reading: what could not be read back is not written.

void require(bool plausible, const char* words) {
  if (!plausible) throw ImplausibleMap(words);
}

void require(const Pose2& pose, const char* of, double farthest = kPlausible.stored_farthest) {
  if (const std::string words = implausibilityOf(pose, farthest); !words.empty())
    throw ImplausibleMap(std::string("holds ") + of + " that cannot be: " + words);
}

/// [m] along a ray
bool isStretch(float from, float to) { return from >= 0.0F && to >= from && to < kPlausible.range; }

void check(const StoredScan& scan, const Pose2& T_map_base) {
  require(T_map_base, "a pose");
  require(scan.T_base_lidar, "a lidar's mounting", kPlausible.mounting);
  for (const Keyframe::Point& point : scan.points)
    require(isWithin(point.x, kPlausible.range) && isWithin(point.y, kPlausible.range),
            "holds a point that no lidar sees: it is not finite, or too far away");
}

/// @param keyframes that there are
void check(const Edge& edge, int keyframes) {
  require(edge.T_from_to, "an edge", 2.0 * kPlausible.stored_farthest);
  require((edge.information.array().abs() <= kPlausible.information).all(),
          "holds an edge whose information is not finite, or beyond all that is known");
  require(edge.from >= 0 && edge.to >= 0 && edge.from < keyframes && edge.to < keyframes && edge.from != edge.to &&
              edge.kind <= EdgeKind::kLoopClosure,
          "holds an edge between keyframes that are not there");
}

/// @param keyframes that there are
void check(const MapView& view, int keyframes) {
  require(view.keyframe >= 0 && view.keyframe < keyframes, "holds a view of a keyframe that is not there");
  require(view.T_keyframe_base, "a view", 2.0 * kPlausible.stored_farthest);
  require(view.view->T_base_depth, "a camera's mounting", kPlausible.mounting);
  for (const DepthView::Beam& beam : view.view->beams)
    require(isWithin(beam.bearing, kPlausible.bearing) && isStretch(beam.free_from, beam.range),
            "holds a beam that is none");
  for (const DepthView::Surface& surface : view.view->surfaces)
    require(isWithin(surface.bearing, kPlausible.bearing) && isStretch(surface.from, surface.to),
            "holds a surface that is none");
}

/// What encodeState() writes.
void check(const MapState& map) {
  require(map.T_map_base, "a last pose");
  require(map.utime >= 0, "holds a time before 1970");
  require(isWithin(map.gyro_bias, kPlausible.turn_rate), "holds a gyro bias that no gyro has");
  require(map.T_base_lidar, "a lidar's mounting", kPlausible.mounting);
  require(map.range_max >= 0.0 && map.range_max <= static_cast<double>(kPlausible.range),
          "holds a range that no lidar has");
  require(map.grid_keyframes >= 0, "counts keyframes below zero");
}

/// @param resolution [m]
void checkGrid(double resolution) {
  if (const std::string words = implausibilityOfResolution(resolution); !words.empty())
    throw ImplausibleMap("holds a grid that cannot be: " + words);
}

/// @param resolution [m] that passed checkGrid()
void check(TileIndex tile, double resolution) {
  const double farthest = (kPlausible.stored_farthest + static_cast<double>(kPlausible.range)) / resolution;  // [cells]
  const double column = static_cast<double>(tile.column) * OccupancyGrid::kTileSide,
               row = static_cast<double>(tile.row) * OccupancyGrid::kTileSide;
  require(isWithin(column, farthest) && isWithin(row, farthest), "holds a tile that lies too far off");
}

void putPose(BinaryWriter& out, const Pose2& pose) {
  for (const double value : {pose.x, pose.y, pose.theta}) out.put(value);
}

Pose2 getPose(BinaryReader& in) {
  const double x = in.get<double>(), y = in.get<double>();
  return {x, y, in.get<double>()};
}

std::string encodeLayer(const OccupancyGrid& grid, LogOdds OccupancyGrid::Cell::*layer) {
  BinaryWriter raw;
  checkGrid(grid.resolution());
  grid.tiles().forEachTile([&](TileIndex tile, const OccupancyGrid::Tiles::Tile& data) {
    check(tile, grid.resolution());
    raw.put(static_cast<std::int32_t>(tile.column));
    raw.put(static_cast<std::int32_t>(tile.row));
    for (const OccupancyGrid::Cell& cell : data.cells) raw.put(cell.*layer);
  });
  uLongf size = ::compressBound(raw.bytes().size());
  std::string compressed(size, '\0');
  if (::compress2(reinterpret_cast<Bytef*>(compressed.data()), &size,
                  reinterpret_cast<const Bytef*>(raw.bytes().data()), raw.bytes().size(), Z_BEST_SPEED) != Z_OK) {
    throw std::runtime_error("the grid cannot be compressed");
  }
  compressed.resize(size);
  BinaryWriter out;
  out.put(grid.resolution());
  out.put(static_cast<std::uint64_t>(raw.bytes().size()));
  out.putBytes(compressed);
  return out.take();
}

/// Calls set(CellIndex, LogOdds) for each cell that something is known of.
template <typename Set>
void decodeLayer(std::string_view bytes, Set&& set) {
  BinaryReader in(bytes);
  const auto resolution = in.get<double>();
  checkGrid(resolution);
  const auto size = in.get<std::uint64_t>();
  const std::string_view compressed = in.rest();
  if (size / kMostPacked > compressed.size() || size % kTileBytes != 0)
    throw std::runtime_error("its grid has no size");
  std::string raw(size, '\0');
  uLongf unpacked = size;
  if (::uncompress(reinterpret_cast<Bytef*>(raw.data()), &unpacked, reinterpret_cast<const Bytef*>(compressed.data()),
                   compressed.size()) != Z_OK ||
      unpacked != size) {
    throw std::runtime_error("its grid does not unpack");
  }
  for (BinaryReader tiles(raw); !tiles.atEnd();) {
    const auto column = tiles.get<std::int32_t>(), row = tiles.get<std::int32_t>();
    check(TileIndex{column, row}, resolution);
    const std::string_view cells = tiles.getBytes(kTileCells * sizeof(LogOdds));
    for (int i = 0; i < static_cast<int>(kTileCells); ++i) {
      LogOdds log_odds;
      std::memcpy(&log_odds, cells.data() + static_cast<std::size_t>(i) * sizeof(LogOdds), sizeof(LogOdds));
      if (log_odds == 0) continue;
      set(CellIndex{column * OccupancyGrid::kTileSide + i % OccupancyGrid::kTileSide,
                    row * OccupancyGrid::kTileSide + i / OccupancyGrid::kTileSide},
          log_odds);
    }
  }
}

}  // namespace

void encodeNode(BinaryWriter& out, const StoredScan& scan, const Pose2& T_map_base, bool in_map) {
  check(scan, T_map_base);
  out.put(static_cast<std::int64_t>(scan.stamp.time_since_epoch().count()));
  putPose(out, T_map_base);
  putPose(out, scan.T_base_lidar);
  out.put(static_cast<std::uint8_t>(in_map));
  out.put(static_cast<std::uint64_t>(scan.points.size()));
  for (const Keyframe::Point& point : scan.points) {
    out.put(point.x);
    out.put(point.y);
    out.put(point.normal);
    out.put(point.normal_sigma);
  }
}

void decodeNode(BinaryReader& in, MapState& map) {
  auto scan = std::make_shared<StoredScan>();
  scan->stamp = Timestamp(Duration(in.get<std::int64_t>()));
  const Pose2 T_map_base = getPose(in);
  scan->T_base_lidar = getPose(in);
  const bool in_map = in.get<std::uint8_t>() != 0;
  scan->points.resize(in.getCount(kPointBytes));
  for (Keyframe::Point& point : scan->points) {
    point.x = in.get<float>();
    point.y = in.get<float>();
    point.normal = in.get<std::int16_t>();
    point.normal_sigma = in.get<std::uint16_t>();
  }
  check(*scan, T_map_base);
  map.keyframes.add(std::move(scan), T_map_base);
  map.in_map.push_back(in_map);
}

void encodeEdge(BinaryWriter& out, const Edge& edge) {
  check(edge, std::numeric_limits<int>::max());
  out.put(static_cast<std::int32_t>(edge.from));
  out.put(static_cast<std::int32_t>(edge.to));
  putPose(out, edge.T_from_to);
  for (int row = 0; row < 3; ++row) {
    for (int column = row; column < 3; ++column) out.put(edge.information(row, column));
  }
  out.put(static_cast<std::uint8_t>(edge.kind));
  out.put(static_cast<std::uint8_t>(edge.revoked));
}

void decodeEdge(BinaryReader& in, MapState& map) {
  Edge edge;
  edge.from = in.get<std::int32_t>();
  edge.to = in.get<std::int32_t>();
  edge.T_from_to = getPose(in);
  for (int row = 0; row < 3; ++row) {
    for (int column = row; column < 3; ++column) {
      edge.information(row, column) = edge.information(column, row) = in.get<double>();
    }
  }
  edge.kind = static_cast<EdgeKind>(in.get<std::uint8_t>());
  edge.revoked = in.get<std::uint8_t>() != 0;
  check(edge, map.keyframes.size());
  map.keyframes.graph().addEdge(edge);
}

void encodePoses(BinaryWriter& out, std::span<const Pose2> poses) {
  out.put(static_cast<std::uint64_t>(poses.size()));
  for (const Pose2& pose : poses) {
    require(pose, "a pose");
    putPose(out, pose);
  }
}

void decodePoses(BinaryReader& in, MapState& map) {
  std::vector<Pose2> poses(in.getCount(3 * sizeof(double)));
  if (poses.size() > static_cast<std::size_t>(map.keyframes.size()))
    throw std::runtime_error("moves keyframes that are not there");
  for (Pose2& pose : poses) {
    pose = getPose(in);
    require(pose, "a pose");
  }
  for (std::size_t id = 0; id < poses.size(); ++id) map.keyframes.graph().setPose(static_cast<int>(id), poses[id]);
}

std::string encodeKeyframes(const MapState& map) {
  BinaryWriter out;
  out.put(static_cast<std::uint64_t>(map.keyframes.size()));
  for (int id = 0; id < map.keyframes.size(); ++id) {
    encodeNode(out, wholeScan(map, id), map.keyframes.pose(id), map.in_map[static_cast<std::size_t>(id)] != 0);
  }
  return out.take();
}

void decodeKeyframes(std::string_view bytes, MapState& map) {
  BinaryReader in(bytes);
  for (std::size_t left = in.getCount(kNodeBytes); left > 0; --left) decodeNode(in, map);
}

std::string encodeEdges(const MapState& map) {
  BinaryWriter out;
  const auto edges = map.keyframes.graph().edges();
  out.put(static_cast<std::uint64_t>(edges.size()));
  for (const Edge& edge : edges) encodeEdge(out, edge);
  return out.take();
}

void decodeEdges(std::string_view bytes, MapState& map) {
  BinaryReader in(bytes);
  for (std::size_t left = in.getCount(kEdgeBytes); left > 0; --left) decodeEdge(in, map);
}

std::string encodeGrid(const OccupancyGrid& grid) { return encodeLayer(grid, &OccupancyGrid::Cell::lidar); }

OccupancyGrid decodeGrid(std::string_view bytes, OccupancyGridConfig config) {
  config.resolution = BinaryReader(bytes).get<double>();
  checkGrid(config.resolution);
  OccupancyGrid grid(config);
  decodeLayer(bytes, [&](CellIndex cell, LogOdds lidar) { grid.set(cell, lidar); });
  return grid;
}

void encodeView(BinaryWriter& out, const MapView& view) {
  check(view, std::numeric_limits<int>::max());
  out.put(static_cast<std::int32_t>(view.keyframe));
  putPose(out, view.T_keyframe_base);
  out.put(static_cast<std::int64_t>(view.view->stamp.time_since_epoch().count()));
  putPose(out, view.view->T_base_depth);
  out.put(static_cast<std::uint64_t>(view.view->beams.size()));
  for (const DepthView::Beam& beam : view.view->beams) {
    for (const float value : {beam.bearing, beam.range, beam.free_from}) out.put(value);
    out.put(static_cast<std::uint8_t>(beam.hit));
  }
  out.put(static_cast<std::uint64_t>(view.view->surfaces.size()));
  for (const DepthView::Surface& surface : view.view->surfaces) {
    for (const float value : {surface.bearing, surface.from, surface.to}) out.put(value);
  }
}

MapView decodeView(BinaryReader& in, const MapState& map) {
  MapView view;
  view.keyframe = in.get<std::int32_t>();
  view.T_keyframe_base = getPose(in);
  auto depth = std::make_shared<DepthView>();
  depth->stamp = Timestamp(Duration(in.get<std::int64_t>()));
  depth->T_base_depth = getPose(in);
  depth->beams.resize(in.getCount(kBeamBytes));
  for (DepthView::Beam& beam : depth->beams) {
    for (float* value : {&beam.bearing, &beam.range, &beam.free_from}) *value = in.get<float>();
    beam.hit = in.get<std::uint8_t>() != 0;
  }
  depth->surfaces.resize(in.getCount(kSurfaceBytes));
  for (DepthView::Surface& surface : depth->surfaces) {
    for (float* value : {&surface.bearing, &surface.from, &surface.to}) *value = in.get<float>();
  }
  view.view = std::move(depth);
  check(view, map.keyframes.size());
  view.T_map_keyframe = map.keyframes.pose(view.keyframe);
  return view;
}

std::string encodeDepth(const MapState& map) {
  BinaryWriter out;
  out.put(static_cast<std::uint64_t>(map.views.size()));
  for (const MapView& view : map.views) encodeView(out, view);
  out.putBytes(encodeLayer(map.grid, &OccupancyGrid::Cell::depth));
  return out.take();
}

void decodeDepth(std::string_view bytes, MapState& map) {
  BinaryReader in(bytes);
  std::vector<MapView> views(in.getCount(kViewBytes));
  for (MapView& view : views) view = decodeView(in, map);
  std::vector<std::pair<CellIndex, LogOdds>> cells;  // the grid stays as it is where they do not unpack
  decodeLayer(in.rest(), [&](CellIndex cell, LogOdds depth) { cells.emplace_back(cell, depth); });
  for (const auto& [cell, depth] : cells) map.grid.set(cell, map.grid.tiles().read(cell).lidar, depth);
  map.views = std::move(views);
}

std::string encodeState(const MapState& map) {
  check(map);
  std::ostringstream text;
  const auto pose = [](const Pose2& p) {
    std::ostringstream list;
    list << std::setprecision(17) << std::showpoint << "[" << p.x << ", " << p.y << ", " << p.theta << "]";
    return list.str();
  };
  text << std::setprecision(17) << std::showpoint << "# last pose of base in map [m, m, rad]\n"
       << "T_map_base = " << pose(map.T_map_base) << "\n# [us] since 1970, of that pose\nutime = " << map.utime
       << "\n# [rad/s] about z\ngyro_bias = " << map.gyro_bias
       << "\n# the lidar that the keyframes were taken with\nT_base_lidar = " << pose(map.T_base_lidar)
       << "\nlidar_range_max = " << map.range_max << "  # [m]\n"
       << "# scans drawn into the grid\ngrid_keyframes = " << map.grid_keyframes << "\n";
  if (map.body.degrees() > 0) {
    text << "# what moves with the robot: [deg, mm] in the lidar's frame\nbody = [";
    const char* separator = "";
    for (std::size_t i = 0; i < map.body.millimetres.size(); ++i) {
      if (map.body.millimetres[i] == 0) continue;
      text << std::exchange(separator, ", ") << "[" << i << ", " << map.body.millimetres[i] << "]";
    }
    text << "]\n";
  }
  return text.str();
}

void decodeState(std::string_view text, MapState& map) {
  MapState read;  // the map stays as it is where it cannot be
  try {
    const toml::table table = toml::parse(text);
    const auto number = [&](const char* key) {
      const auto value = table[key].value<double>();
      if (!value) throw std::runtime_error(std::string("has no number ") + key);
      return *value;
    };
    const auto pose = [&](const char* key) {
      std::array<double, 3> v{};
      for (std::size_t i = 0; i < 3; ++i) {
        const auto value = table[key][i].value<double>();
        if (!value) throw std::runtime_error(std::string("has no pose ") + key);
        v[i] = *value;
      }
      return Pose2{v[0], v[1], v[2]};
    };
    read.T_map_base = pose("T_map_base");
    const auto integer = [&](const char* key) {
      const auto value = table[key].value<std::int64_t>();
      if (!value) throw std::runtime_error(std::string("has no count ") + key);
      return *value;
    };
    read.utime = integer("utime");
    read.gyro_bias = number("gyro_bias");
    read.T_base_lidar = pose("T_base_lidar");
    read.range_max = number("lidar_range_max");
    if (const toml::array* body = table["body"].as_array()) {
      for (std::size_t k = 0; k < body->size(); ++k) {
        const auto degree = table["body"][k][0].value<std::int64_t>(),
                   range = table["body"][k][1].value<std::int64_t>();
        const bool known = degree && *degree >= 0 && *degree < std::ssize(read.body.millimetres) && range &&
                           *range > 0 && *range <= UINT16_MAX;
        if (!known) throw std::runtime_error("has a body that is no list of degrees and ranges");
        read.body.millimetres[static_cast<std::size_t>(*degree)] = static_cast<std::uint16_t>(*range);
      }
    }
    read.grid_keyframes = static_cast<int>(std::clamp<std::int64_t>(integer("grid_keyframes"), -1, INT_MAX));
    check(read);
  } catch (const toml::parse_error& error) {
    throw std::runtime_error(std::string(error.description()));
  }
  map.T_map_base = read.T_map_base;
  map.utime = read.utime;
  map.gyro_bias = read.gyro_bias;
  map.T_base_lidar = read.T_base_lidar;
  map.range_max = read.range_max;
  map.body = read.body;  // older maps know none
  map.grid_keyframes = read.grid_keyframes;
}

}  // namespace slam
