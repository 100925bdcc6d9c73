// SPDX-License-Identifier: BSD-3-Clause
#include "tools/slamctl/map_edits.hpp"

#include <cstdio>
#include <nlohmann/json.hpp>
#include <pwd.h>
#include <stdexcept>
#include <unistd.h>

#include "slam/edits/edit_json.hpp"
#include "store/map_store.hpp"
#include "tools/slamctl/health_json.hpp"

namespace slam {

std::string userName() {
  const passwd* const user = ::getpwuid(::getuid());
  return user != nullptr ? user->pw_name : std::to_string(::getuid());
}

MapEditing::MapEditing(CLI::App& app) {
  map_ = app.add_subcommand("map",
                            "edits of the map: what a person draws into it; they move with it and are stored in it");
  map_->require_subcommand(1);
  const auto add = [&](EditKind kind, const char* what, const char* points) {
    CLI::App* const edit = map_->add_subcommand(nameOf(kind), what);
    if (kind == EditKind::kRoom || kind == EditKind::kPlace)
      edit->add_option("NAME", name_, "64 bytes at most")->required();
    CLI::Option* const numbers = edit->add_option("NUMBERS", numbers_, points);
    if (kind != EditKind::kPlace) numbers->required();
    return edit;
  };
  constexpr const char* kOutline = "X Y of each corner [m, in map]";
  add(EditKind::kErase, "take what was seen in an outline out of the map; what is seen later is drawn again", kOutline)
      ->add_flag("--force", force_, "also where the robot loses what it finds its place by");
  add(EditKind::kFree, "never draw an obstacle in an outline: glass, a curtain", kOutline);
  add(EditKind::kWall, "a line that nothing may pass; for exports and other programs", "X Y of each point [m, in map]");
  add(EditKind::kNoGo, "a zone that the robot shall not enter; for exports and other programs", kOutline);
  add(EditKind::kRoom, "a name for an outline, or for a spot", "X Y of each corner, or of the spot [m, in map]");
  add(EditKind::kPlace, "a name for a pose, such as dock; without numbers: where the robot is",
      "X Y THETA [m, m, rad, in map]")
      ->add_option("--sigma", sigma_, "X Y THETA: how exactly it is known [m, m, rad]")
      ->expected(3);
  map_->add_subcommand("edits", "the edits of a stored map")
      ->add_option("NAME", name_, "of a map; default: the newest one");
  map_->add_subcommand("straighten", "turn the map so that most walls lie along its axes; the robot's pose moves along")
      ->add_option("--origin", name_, "a place that is the origin from now on");
  map_->add_subcommand("undo", "undo the last step");
  map_->add_subcommand("redo", "do again what was undone last");
  map_->add_subcommand("remove", "take an edit back")
      ->add_option("ID", id_, "of the edit, as edits shows it")
      ->required();
  for (CLI::App* command : map_->get_subcommands({})) command->fallthrough();
}

std::optional<std::pair<std::string, std::string>> MapEditing::command() const {
  const std::string what = map_->get_subcommands().front()->get_name();
  if (what == "edits") return std::nullopt;
  if (what == "undo" || what == "redo") return std::pair{"map_" + what, std::string()};
  if (what == "straighten") return std::pair{std::string("map_straighten"), name_};
  if (what == "remove") return std::pair{std::string("map_remove"), std::to_string(id_)};
  nlohmann::json edit = {{"kind", what}, {"by", userName()}};
  if (!name_.empty()) edit["name"] = name_;
  if (force_) edit["force"] = true;
  if (!sigma_.empty()) edit["sigma"] = sigma_;
  std::vector<double> numbers = numbers_;
  if (what == "place" && !numbers.empty()) {
    if (numbers.size() != 3) throw std::runtime_error("map place: give X, Y and THETA, or none of them");
    edit["theta"] = numbers.back();
    numbers.pop_back();
  }
  if (numbers.size() % 2 != 0) throw std::runtime_error("map " + what + ": a Y is missing; give X and Y of each point");
  for (std::size_t i = 0; i < numbers.size(); i += 2) edit["points"].push_back({numbers[i], numbers[i + 1]});
  return std::pair{std::string("map_edit"), textOf(edit)};
}

void MapEditing::list(const std::string& directory, const Config& config, bool json) const {
  const auto newest = name_.empty() ? MapStore::newest(directory) : std::optional(name_);
  if (!newest) throw std::runtime_error(directory + ": there is no map");
  if (!MapStore::isName(*newest)) throw std::runtime_error("\"" + *newest + "\" is no name of a map");
  const MapState map = MapStore::load(directory, *newest, config.map).state;
  const std::string text = editsJson(map.edits, map.keyframes, map.in_map);
  if (json) {
    std::printf("%s\n", text.c_str());
    return;
  }
  const auto list = nlohmann::json::parse(text);
  for (const auto& edit : list) {
    const auto& first = edit["points"][0];
    std::printf("%4d  %-6s %-24s %4zu point%s from %.2f, %.2f m  by %s\n", edit["id"].get<int>(),
                edit["kind"].get<std::string>().c_str(), edit.value("name", "").c_str(), edit["points"].size(),
                edit["points"].size() == 1 ? " " : "s", first[0].get<double>(), first[1].get<double>(),
                edit["by"].get<std::string>().c_str());
  }
  std::printf("%zu edit%s of map %s\n", list.size(), list.size() == 1 ? "" : "s", newest->c_str());
}

}  // namespace slam
