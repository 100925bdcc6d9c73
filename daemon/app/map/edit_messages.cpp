// SPDX-License-Identifier: BSD-3-Clause
#include "app/map/edit_messages.hpp"

#include <utility>

namespace slam {

std::vector<map_edit_t> editMessages(const KeyframeMap& map, std::int32_t map_id) {
  std::vector<map_edit_t> messages;
  if (map.edits.empty()) return messages;
  const auto add = [&]() -> map_edit_t& {
    map_edit_t message{};
    message.map_id = map_id;
    message.revision = map.edits.revision;
    message.index = static_cast<std::int32_t>(messages.size());
    return messages.emplace_back(std::move(message));
  };
  for (const MapEdit& edit : map.edits.edits) {
    const Outline points = pointsOf(edit, map.keyframes, map.in_map);
    if (!edit.active || points.empty()) continue;
    map_edit_t& message = add();
    message.utime = edit.utime;
    message.id = edit.id;
    message.kind = nameOf(edit.kind);
    message.name = edit.name;
    message.author = edit.author;
    message.npoints = static_cast<std::int32_t>(points.size());
    for (const Eigen::Vector2d& p : points) {
      message.x.push_back(p.x());
      message.y.push_back(p.y());
    }
    if (edit.kind != EditKind::kPlace) continue;
    message.theta = poseOf(edit, map.keyframes).theta;
    for (int i = 0; i < 3; ++i) message.sigma[i] = edit.sigma[i];
  }
  if (messages.empty()) {
    add();
    return messages;
  }
  for (map_edit_t& message : messages) message.edits = static_cast<std::int32_t>(messages.size());
  return messages;
}

}  // namespace slam
