// SPDX-License-Identifier: BSD-3-Clause
#include "tools/sim/world/scenes.hpp"

#include <stdexcept>

#include "tools/sim/world/scene_list.hpp"

namespace slam::sim {

std::vector<std::string> sceneNames() {
  return {"meeting-room", "tile-rectangle", "corridor-loop", "office-floor", "gazebo", "people", "open-door"};
}

Scene makeScene(const std::string& name, std::uint64_t seed) {
  if (name == "tile-rectangle") return tileRectangle();
  if (name == "meeting-room") return meetingRoom();
  if (name == "corridor-loop") return corridorLoop(seed);
  if (name == "office-floor") return officeFloor(seed);
  if (name == "gazebo") return gazebo();
  if (name == "people") return people();
  if (name == "open-door") return openDoor();
  std::string known;
  for (const std::string& scene : sceneNames()) known += " " + scene;
  throw std::invalid_argument("scene '" + name + "' is not known; known are" + known);
}

}  // namespace slam::sim
