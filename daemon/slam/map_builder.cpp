// SPDX-License-Identifier: BSD-3-Clause
#include "slam/map_builder.hpp"

#include <utility>

namespace slam {

MapBuilder::MapBuilder(const BackEndConfig& config, const MapState& map, Stopwatch stopwatch)
    : back_end_(config), stopwatch_(stopwatch) {
  if (map.keyframes.size() > 0) back_end_.load(map.keyframes, map.in_map, map.edits, map.floors);
}

MapUpdate MapBuilder::add(const Keyframe& keyframe) {
  const Timestamp begin = stopwatch_ ? stopwatch_() : Timestamp{};
  const BackEndCounters before = back_end_.counters();
  const int generation = back_end_.generation();
  back_end_.add(keyframe, !correction_away_);
  const BackEndCounters now = back_end_.counters();
  MapUpdate update;
  update.first_in_map = back_end_.map().first_in_map;
  update.scans = back_end_.mapScans(keyframe);
  update.elsewhere = back_end_.elsewhere();
  update.relocalised = now.placed > before.placed;
  update.taken_back = now.taken_back > before.taken_back;
  update.begun_anew = now.begun_anew > before.begun_anew;
  update.loop_closed = now.loop_closures > before.loop_closures;
  if (back_end_.generation() != generation) {
    const auto poses = back_end_.keyframes().graph().poses();
    update.poses.assign(poses.begin(), poses.end());
    const KeyframeMap& map = back_end_.map();
    if (!map.edits.empty()) update.edits = drawingOf(map.edits, map.keyframes, map.in_map);
  }
  update.correction = back_end_.takeCorrection();
  correction_away_ |= update.correction != nullptr;
  if (stopwatch_) update.work = stopwatch_() - begin;
  return update;
}

EditOutcome MapBuilder::edit(const EditCommand& command, const Eigen::Vector2d& robot) {
  EditOutcome outcome;
  std::vector<int> changed;
  outcome.problem = back_end_.edit(command, robot, &changed, &outcome.edit);
  if (outcome.problem) return outcome;
  const KeyframeMap& map = back_end_.map();
  for (const int id : changed) outcome.scans.push_back({id, map.keyframes.pose(id), map.keyframes.scan(id)});
  outcome.drawing = drawingOf(map.edits, map.keyframes, map.in_map);
  for (const MapEdit& edit : map.edits.edits) {
    if (edit.id == outcome.edit && edit.kind == EditKind::kErase)
      outcome.anew.push_back(pointsOf(edit, map.keyframes, map.in_map));
  }
  std::erase_if(outcome.anew, [](const Outline& outline) { return outline.empty(); });
  return outcome;
}

void MapBuilder::recycle(std::unique_ptr<MapCorrection> used) {
  back_end_.recycle(std::move(used));
  correction_away_ = false;
}

MapState MapBuilder::state(DrawnMap drawn, int drawn_keyframes) const {
  MapState map;
  map.keyframes = back_end_.keyframes();
  if (back_end_.map().join) back_end_.map().join->revoke(map.keyframes.graph());
  map.in_map = back_end_.map().in_map;
  map.edits = back_end_.map().edits;
  map.grid = std::move(drawn.grid);
  map.views = std::move(drawn.views);
  map.grid_keyframes = drawn_keyframes;
  return map;
}

}  // namespace slam
