// SPDX-License-Identifier: BSD-3-Clause
#include "tools/slamctl/map_list.hpp"

#include <cstdio>
#include <nlohmann/json.hpp>

#include "store/map_store.hpp"
#include "tools/slamctl/log.hpp"

namespace slam {
namespace {

const char* stateOf(const MapSummary& map) {
  return map.newer                      ? "of a newer slamd"
         : map.generation == 0          ? "damaged"
         : map.problem.empty()          ? "good"
         : map.generation != map.newest ? "good, newest generation damaged"
                                        : "usable, in part damaged";
}

}  // namespace

void printMaps(const std::filesystem::path& folder) {
  const auto maps = MapStore::list(folder);
  const auto newest = MapStore::newest(folder);
  std::printf("%-2s%-28s %10s %10s  %-19s  %s\n", "", "map", "keyframes", "generation", "saved (UTC)", "state");
  for (const MapSummary& map : maps) {
    std::printf("%-2s%-28s %10d %10d  %-19s  %s\n", newest == map.name ? "*" : "", map.name.c_str(), map.keyframes,
                map.generation, timeText(map.utime).c_str(), stateOf(map));
    if (!map.problem.empty()) std::printf("  %s\n", map.problem.c_str());
  }
  std::printf("%zu map%s in %s%s\n", maps.size(), maps.size() == 1 ? "" : "s", folder.c_str(),
              newest ? "; * is continued at start" : "");
}

nlohmann::json mapsJson(const std::filesystem::path& folder) {
  auto list = nlohmann::json::array();
  const auto newest = MapStore::newest(folder);
  for (const MapSummary& map : MapStore::list(folder))
    list.push_back({{"name", map.name},
                    {"keyframes", map.keyframes},
                    {"generation", map.generation},
                    {"utime", map.utime},
                    {"state", stateOf(map)},
                    {"problem", map.problem},
                    {"continued_at_start", newest == map.name}});
  return list;
}

}  // namespace slam
