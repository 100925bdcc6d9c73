// SPDX-License-Identifier: BSD-3-Clause
#include "relocalisation/floor_atlas.hpp"

#include <limits>

#include "relocalisation/distance_field.hpp"

namespace slam {

FloorAtlas::FloorAtlas(const KeyframeGraph& present, std::span<const int> ids, const Floors& floors, double gap)
    : gap_(gap) {
  add(present, ids);
  for (const auto& floor : floors.others) {
    std::vector<int> in_map;
    for (int id = 0; id < floor->keyframes.size(); ++id) {
      if (floor->in_map[static_cast<std::size_t>(id)] != 0) in_map.push_back(id);
    }
    add(floor->keyframes, in_map);
  }
}

void FloorAtlas::add(const KeyframeGraph& map, std::span<const int> ids) {
  const double infinity = std::numeric_limits<double>::infinity();
  Eigen::Vector2d low(infinity, infinity), high = -low;
  const auto extend = [&](const Eigen::Vector2d& p) {
    low = low.cwiseMin(p);
    high = high.cwiseMax(p);
  };
  forEachWallPoint(map, ids, extend);
  for (const int id : ids) extend(map.pose(id).translation());
  if (ids.empty()) low = high = Eigen::Vector2d::Zero();
  Floor floor{.begin = -infinity, .origin = Eigen::Vector2d::Zero()};
  if (floors_.empty()) {
    corner_ = {high.x(), low.y()};
  } else {
    floor.begin = corner_.x() + gap_ / 2;
    floor.origin = corner_ + Eigen::Vector2d(gap_, 0.0) - low;
    corner_.x() += gap_ + high.x() - low.x();
  }
  const Pose2 T_atlas_floor{floor.origin.x(), floor.origin.y(), 0.0};
  for (const int id : ids) keyframes_.add(map.scan(id), T_atlas_floor * map.pose(id));
  floors_.push_back(floor);
}

FloorAtlas::Place FloorAtlas::placeOf(const Pose2& T_atlas_base) const {
  int floor = 0;
  while (floor + 1 < std::ssize(floors_) && floors_[static_cast<std::size_t>(floor) + 1].begin <= T_atlas_base.x)
    ++floor;
  const Eigen::Vector2d& origin = floors_[static_cast<std::size_t>(floor)].origin;
  return {floor, {T_atlas_base.x - origin.x(), T_atlas_base.y - origin.y(), T_atlas_base.theta}};
}

}  // namespace slam
