// SPDX-License-Identifier: BSD-3-Clause
#include "store/floor_maps.hpp"

#include <memory>
#include <set>
#include <sstream>
#include <stdexcept>
#include <utility>

#include "store/map_folders.hpp"
#include "store/map_store.hpp"

namespace slam {

std::vector<std::string> floorNames(const std::filesystem::path& directory, const std::string& list) {
  std::string blanks = list;
  for (char& c : blanks) c = c == ',' ? ' ' : c;
  std::set<std::string> names;
  std::istringstream words(blanks);
  for (std::string word; words >> word;) {
    if (word != "*") {
      names.insert(word);
      continue;
    }
    try {
      for (const std::string& name : MapStore::names(directory)) names.insert(name);
    } catch (const DiskError&) {  // it holds none
    }
  }
  return {names.begin(), names.end()};
}

Floors loadFloors(const std::filesystem::path& directory, const std::string& list, const std::string& present,
                  const LidarModel& lidar, std::vector<std::string>* remarks) {
  Floors floors{.present = present, .others = {}};
  for (const std::string& name : floorNames(directory, list)) {
    if (name == present) continue;
    try {
      LoadedMap map = openMap(mapFolder(directory, name), {});
      const std::string misfit = misfitOf(map.state, lidar, false);
      if (!misfit.empty()) throw std::runtime_error(name + ": " + misfit);
      remarks->insert(remarks->end(), map.remarks.begin(), map.remarks.end());
      floors.others.push_back(std::make_shared<const FloorMap>(
          FloorMap{name, std::move(map.state.keyframes), std::move(map.state.in_map)}));
    } catch (const std::runtime_error& error) {
      remarks->push_back(std::string(error.what()) + "; a lost robot is not searched in it");
    }
  }
  return floors;
}

}  // namespace slam
