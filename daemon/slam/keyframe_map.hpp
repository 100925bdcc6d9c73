// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <algorithm>
#include <memory>
#include <utility>
#include <vector>

#include "frontend/map_correction.hpp"
#include "graph/keyframe_graph.hpp"

namespace slam {

/// The keyframes of the map, and those of a session whose place in it is not known yet.
struct KeyframeMap {
  KeyframeGraph keyframes;
  std::vector<char> in_map;                     ///< by id: its place in the map is known
  std::vector<ReferenceKeyframe> in_reference;  ///< those of the front end's reference, by id
  int given = 0;                                ///< keyframes of the stored map that this goes on in
  int first_in_map = 0;                         ///< the ones before are forgotten
  int generation = 0;                           ///< counts up whenever poses of known keyframes changed

  /// Goes on in a stored map. Before anything is added.
  void load(KeyframeGraph map, std::vector<char> known) {
    keyframes = std::move(map);
    given = keyframes.size();
    in_map = std::move(known);
  }
  /// Takes a keyframe that goes on from the newest one. The front end has put it into its reference itself.
  void add(const Keyframe& keyframe, bool known) {
    keyframes.add(keyframe);
    in_map.push_back(known ? 1 : 0);
    in_reference.push_back({keyframe.id, keyframes.pose(keyframe.id)});
  }
  /// Takes the first keyframe of a session. The front end's reference begins with it.
  void begin(const Keyframe& keyframe) {
    keyframes.add(std::make_shared<const StoredScan>(keyframe), keyframe.T_map_base);
    in_map.push_back(0);
    in_reference = {{keyframe.id, keyframe.T_map_base}};
  }
  /// Forgets all but the map that was loaded.
  void truncate() {
    keyframes.truncate(given);
    in_map.resize(static_cast<std::size_t>(given));
    std::erase_if(in_reference, [this](const ReferenceKeyframe& keyframe) { return keyframe.id >= given; });
  }

  int newest() const { return keyframes.size() - 1; }
  bool inReference(int id) const {
    return std::binary_search(in_reference.begin(), in_reference.end(), ReferenceKeyframe{id, {}, {}},
                              [](const auto& a, const auto& b) { return a.id < b.id; });
  }
  bool inMap(int id) const { return in_map[static_cast<std::size_t>(id)] != 0; }
  std::vector<int> idsInMap() const {
    std::vector<int> ids;
    for (int id = 0; id < keyframes.size(); ++id) {
      if (inMap(id)) ids.push_back(id);
    }
    return ids;
  }
};

}  // namespace slam
