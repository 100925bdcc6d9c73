// SPDX-License-Identifier: BSD-3-Clause
#include "tools/web/maps/map_request.hpp"

#include <algorithm>
#include <nlohmann/json.hpp>
#include <stdexcept>

#include "problems/answers.hpp"
#include "slam/edits/edit_json.hpp"
#include "store/map_store.hpp"
#include "tools/slamctl/health_json.hpp"

namespace slam {
namespace {

using nlohmann::json;

/// @throws std::runtime_error where it is no name of a map
std::string mapNameAt(const json& request, const char* key) {
  const auto at = request.find(key);
  if (at != request.end() && at->is_string() && MapStore::isName(at->get<std::string>())) return at->get<std::string>();
  throw CommandRefused(
      {answer::kNoMapName, {}, {at != request.end() && at->is_string() ? at->get<std::string>() : key}});
}

/// @throws std::runtime_error with what is wrong with it
std::string editAt(const json& request) {
  const auto at = request.find("edit");
  const std::string edit = at == request.end() ? "" : textOf(*at);
  if (const Problem problem = problemWith(editRequestOf(edit))) throw CommandRefused(problem);
  return edit;
}

/// @throws std::runtime_error with what is wrong with it
std::optional<std::string> argumentOf(const json& request, const std::string& verb) {
  if (verb == "load" || verb == "delete") return mapNameAt(request, "name");
  if (verb == "rename") return mapNameAt(request, "name") + " " + mapNameAt(request, "to");
  if (verb == "restore" || verb == "map_undo" || verb == "map_redo" || verb == "map_straighten") return "";
  if (verb == "map_edit") return editAt(request);
  if (verb != "map_remove") return std::nullopt;
  const auto id = request.find("id");
  if (id != request.end() && id->is_number_unsigned()) return std::to_string(id->get<std::uint64_t>());
  throw CommandRefused({answer::kNoEditNumber, {}, {"id"}});
}

}  // namespace

std::optional<WebCommand> mapRequestOf(const json& request, const std::string& verb, Answer& problem) {
  try {
    if (auto argument = argumentOf(request, verb)) return WebCommand{.verb = verb, .argument = *std::move(argument)};
  } catch (const std::runtime_error& error) {
    problem = answerOf(error);
  }
  return std::nullopt;
}

}  // namespace slam
