// SPDX-License-Identifier: BSD-3-Clause
#include "tools/sim/world/scenes.hpp"

#include <stdexcept>

#include "tools/sim/world/scene_list.hpp"

namespace slam::sim {

namespace {

Scene originalScene(const std::string& name, std::uint64_t seed, const SceneVariant& variant) {
  if (name == "tile-rectangle") return tileRectangle();
  if (name == "meeting-room") return meetingRoom();
  if (name == "corridor-loop") return corridorLoop(seed);
  if (name == "office-floor") return officeFloor(seed);
  if (name == "gazebo") return gazebo();
  if (name == "people") return people();
  if (name == "open-door") return openDoor();
  if (name == "home") return home(variant.furniture_moved);
  if (name == "homes") return homes(seed, variant.furniture_moved, variant.floor, variant.lift);
  if (name == "hall") return hall(seed);
  if (name == "corridor-30") return bareCorridor(30.0);
  if (name == "corridor-60") return bareCorridor(60.0);
  if (name == "streets") return streets(seed, variant.blocks);
  std::string known;
  for (const std::string& scene : sceneNames()) known += " " + scene;
  throw std::invalid_argument("scene '" + name + "' is not known; known are" + known);
}

}  // namespace

std::vector<std::string> sceneNames() {
  return {"meeting-room", "tile-rectangle", "corridor-loop", "office-floor", "gazebo",      "people", "open-door",
          "home",         "homes",          "hall",          "corridor-30",  "corridor-60", "streets"};
}

Scene makeScene(const std::string& name, std::uint64_t seed, const SceneVariant& variant) {
  Scene scene = originalScene(name, seed, variant);
  if (variant.furniture_moved != 0 && name != "home" && name != "homes") {
    throw std::invalid_argument("the scene " + name + " has no furniture to move; home and homes have");
  }
  if ((variant.floor != 0 || variant.lift) && name != "homes") {
    throw std::invalid_argument("the scene " + name + " has no other floors and no lift; homes has");
  }
  if (variant.blocks != SceneVariant{}.blocks && name != "streets") {
    throw std::invalid_argument("the scene " + name + " has no blocks; streets has");
  }
  if (variant.laps > 1) {
    if (scene.route.back().pose.translation().norm() > 0.01) {
      throw std::invalid_argument("the route of the scene " + name + " does not end where it starts");
    }
    const std::vector<Waypoint> lap = scene.route;
    for (int i = 1; i < variant.laps; ++i) scene.route.insert(scene.route.end(), lap.begin(), lap.end());
  }
  return scene;
}

}  // namespace slam::sim
