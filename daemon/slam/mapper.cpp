// SPDX-License-Identifier: BSD-3-Clause
#include "slam/mapper.hpp"

namespace slam {

void Mapper::add(const Keyframe& keyframe) {
  grid_.add(keyframe);
  if (!keyframe.look) path_.emplace_back(keyframe.T_map_base.x, keyframe.T_map_base.y);
}

void Mapper::reset() {
  grid_ = OccupancyGrid(config_);
  path_.clear();
}

}  // namespace slam
