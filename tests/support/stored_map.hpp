// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <memory>
#include <random>
#include <string>
#include <utility>

#include "slam/map_state.hpp"

namespace slam::test {

inline OccupancyGridConfig smallGrid() {
  OccupancyGridConfig config;
  config.resolution = 0.1;
  return config;
}

/// A small map that changes step by step as a map does while driving: keyframes, edges, corrections, closures taken
/// back, segments lost and found.
class ChangingMap {
 public:
  explicit ChangingMap(int keyframes = 4) {
    map.grid = OccupancyGrid(smallGrid());
    map.T_base_lidar = {0.06, 0.0, 0.01};
    map.range_max = 12.0;
    for (int id = 0; id < keyframes; ++id) addKeyframe(true);
    closeLoop(0, keyframes - 1);
    map.grid_keyframes = map.keyframes.size();
    touch();
  }

  void addKeyframe(bool in_map) {
    auto scan = std::make_shared<StoredScan>();
    scan->stamp = Timestamp(fromSeconds(100.0 + map.keyframes.size()));
    scan->T_base_lidar = map.T_base_lidar;
    for (int i = 0; i < 3; ++i) {
      scan->points.push_back({static_cast<float>(1.0 + uniform()), static_cast<float>(2.0 * uniform()),
                              static_cast<std::int16_t>(i == 0 ? Keyframe::Point::kNoNormal : 1000 * i),
                              static_cast<std::uint16_t>(10 * i)});
    }
    const int id = map.keyframes.size();
    const Pose2 pose{0.3 * id, 0.2 * uniform(), 0.1 * uniform()};
    if (in_map) map.grid.add(pose, scan->T_base_lidar, scan->points);
    map.keyframes.add(std::move(scan), pose);
    map.in_map.push_back(in_map);
    if (id > 0) addEdge(id - 1, id, EdgeKind::kMotion);
  }
  void closeLoop(int from, int to) { addEdge(from, to, EdgeKind::kLoopClosure); }
  void move() {
    for (int id = 1; id < map.keyframes.size(); ++id) {
      const Pose2& pose = map.keyframes.pose(id);
      map.keyframes.graph().setPose(id, {pose.x + 0.01 * uniform(), pose.y - 0.01, pose.theta + 0.001});
    }
  }
  /// The robot went on: pose, bias and time of the map are others.
  void touch() {
    map.T_map_base = {uniform(), uniform(), uniform()};
    map.gyro_bias = 0.01 * uniform();
    map.body.millimetres[170] = 253;
    map.body.millimetres[359] = 65535;
    map.utime += 1'700'000'000'123'456;
    map.utime %= 4'000'000'000'000'000;
  }
  MapState copy() const { return map.clone(); }

  MapState map;

 private:
  double uniform() { return std::uniform_real_distribution<double>(0.0, 1.0)(random_); }
  void addEdge(int from, int to, EdgeKind kind) {
    Edge edge{.from = from, .to = to, .T_from_to = {uniform(), uniform(), uniform()}, .kind = kind};
    const Eigen::Vector3d v(uniform(), uniform(), uniform());
    edge.information = v * v.transpose() + Eigen::Matrix3d::Identity();
    map.keyframes.graph().addEdge(edge);
  }
  std::mt19937 random_{5};
};

/// What a depth camera saw from near a keyframe: one hit, one free stretch, and a surface behind the hit.
inline MapView viewFrom(int keyframe, const Pose2& T_map_keyframe) {
  auto view = std::make_shared<DepthView>();
  view->stamp = Timestamp(std::chrono::seconds(7));
  view->T_base_depth = {0.1, 0.0, 0.02};
  view->beams = {{-0.1F, 2.0F, 1.0F, true}, {0.1F, 3.0F, 3.0F, false}};
  view->surfaces = {{-0.1F, 2.2F, 2.9F}};
  return {keyframe, T_map_keyframe, {0.2, 0.1, 0.3}, view};
}

/// Makes an edit of a map, as the back end does.
inline std::string edit(MapState& map, EditCommand command) {
  int concerned = 0;
  const Problem problem = map.edits.carryOut(command, map.keyframes, map.in_map, &concerned);
  if (!problem) eraseFrom(map.keyframes, map.edits);
  return problem.words();
}

/// A square of 1 m.
inline EditCommand squareEdit(EditKind kind, double x, double y) {
  EditCommand command;
  command.request.kind = kind;
  command.request.author = "test";
  command.request.name = kind == EditKind::kRoom ? "Kitchen" : "";
  command.request.points = {{x, y}, {x + 1.0, y}, {x + 1.0, y + 1.0}, {x, y + 1.0}};
  command.utime = 1'700'000'000'000'000;
  return command;
}

/// What differs first between two maps but for their grids; empty: nothing.
inline std::string differenceOf(const MapState& a, const MapState& b) {
  if (a.keyframes.size() != b.keyframes.size()) {
    return "keyframes: " + std::to_string(a.keyframes.size()) + " and " + std::to_string(b.keyframes.size());
  }
  if (a.in_map != b.in_map) return "in_map";
  for (int id = 0; id < a.keyframes.size(); ++id) {
    const StoredScan &x = *a.keyframes.scan(id), &y = *b.keyframes.scan(id);
    const std::string name = " of keyframe " + std::to_string(id);
    if (!(a.keyframes.pose(id) == b.keyframes.pose(id))) return "pose" + name;
    if (x.stamp != y.stamp || !(x.T_base_lidar == y.T_base_lidar)) return "stamp or lidar" + name;
    const auto same = [](const Keyframe::Point& p, const Keyframe::Point& q) {
      return p.x == q.x && p.y == q.y && p.normal == q.normal && p.normal_sigma == q.normal_sigma;
    };
    if (!std::equal(x.points.begin(), x.points.end(), y.points.begin(), y.points.end(), same)) return "points" + name;
  }
  const auto same = [](const Edge& p, const Edge& q) {
    return p.from == q.from && p.to == q.to && p.T_from_to == q.T_from_to && p.information == q.information &&
           p.kind == q.kind && p.revoked == q.revoked;
  };
  const auto edges = a.keyframes.graph().edges(), others = b.keyframes.graph().edges();
  if (!std::equal(edges.begin(), edges.end(), others.begin(), others.end(), same)) return "edges";
  const auto same_edit = [](const MapEdit& p, const MapEdit& q) {
    const auto same_corner = [](const MapEdit::Corner& c, const MapEdit::Corner& d) {
      return c.keyframe == d.keyframe && c.p_keyframe == d.p_keyframe;
    };
    return p.id == q.id && p.active == q.active && p.kind == q.kind && p.name == q.name && p.author == q.author &&
           p.utime == q.utime && p.theta == q.theta && p.sigma == q.sigma && p.outline == q.outline &&
           p.T_keyframe_map == q.T_keyframe_map &&
           std::equal(p.corners.begin(), p.corners.end(), q.corners.begin(), q.corners.end(), same_corner);
  };
  const MapEdits &e = a.edits, &f = b.edits;
  const bool counts =
      e.made == f.made && e.revision == f.revision && e.done == f.done && e.steps.size() == f.steps.size();
  if (!counts || !std::equal(e.edits.begin(), e.edits.end(), f.edits.begin(), f.edits.end(), same_edit)) return "edits";
  const bool state = a.T_map_base == b.T_map_base && a.gyro_bias == b.gyro_bias && a.body == b.body &&
                     a.utime == b.utime && a.T_base_lidar == b.T_base_lidar && a.range_max == b.range_max;
  return state ? "" : "state";
}

inline bool sameCells(const OccupancyGrid& a, const OccupancyGrid& b) {
  if (a.resolution() != b.resolution()) return false;
  const auto covers = [](const OccupancyGrid& whole, const OccupancyGrid& part) {
    bool same = true;
    part.tiles().forEachTile([&](TileIndex tile, const OccupancyGrid::Tiles::Tile& data) {
      for (int i = 0; i < OccupancyGrid::kTileSide * OccupancyGrid::kTileSide; ++i) {
        const int column = i % OccupancyGrid::kTileSide, row = i / OccupancyGrid::kTileSide;
        same &= part.fused(data.at(column, row)) == whole.logOdds({tile.column * OccupancyGrid::kTileSide + column,
                                                                   tile.row * OccupancyGrid::kTileSide + row});
      }
    });
    return same;
  };
  return covers(a, b) && covers(b, a);
}

/// The grid that drawing the keyframes and views of a map gives.
inline OccupancyGrid drawn(const MapState& map) {
  OccupancyGrid grid(smallGrid());
  const EditedDrawing edits = drawingOf(map);
  for (int id = 0; id < map.keyframes.size(); ++id) {
    if (map.in_map[static_cast<std::size_t>(id)] == 0) continue;
    grid.add(map.keyframes.pose(id), map.keyframes.scan(id)->T_base_lidar, map.keyframes.scan(id)->points);
  }
  for (const MapView& view : viewsOf(map))
    grid.add(view.T_map_base() * view.view->T_base_depth, *shownOf(view, edits.erased));
  FreeCells free(edits.free, grid.resolution());
  grid.tiles().forEachTile([&](TileIndex tile, const auto&) { free.apply(grid, {&tile, 1}); });
  return grid;
}

}  // namespace slam::test
