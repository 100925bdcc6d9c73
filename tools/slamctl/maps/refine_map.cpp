// SPDX-License-Identifier: BSD-3-Clause
#include "tools/slamctl/maps/refine_map.hpp"

#include <cmath>
#include <cstdio>
#include <stdexcept>
#include <sys/resource.h>
#include <sys/syscall.h>
#include <unistd.h>

#include "store/durable_file.hpp"
#include "store/map_folders.hpp"
#include "tools/common/refinement_words.hpp"
#include "tools/slamctl/maps/stored_map.hpp"

namespace slam {
namespace {

constexpr double kSecondsPerKeyframe = 1.5e-3;  // of one core at lowest load, all rounds: streets on a 3 GHz x86-64
constexpr double kBytesPerKeyframe = 14e3;      // beside its points: edges, indices, the optimiser's share
constexpr double kCopies = 2.0;                 // of the map: as loaded, and as it is read again before it is replaced
constexpr double kComputed = 0.88;              // [1] of the time; the rest stores the result
constexpr double kProgram = 60.0;               // [MB] submap, grids and code

/// Behind all that slamd does: its CPU time and its disk.
void yieldToOthers() {
  constexpr int kWhoProcess = 1, kIdleClass = 3 << 13;  // of ioprio_set(2), which has no header
  setpriority(PRIO_PROCESS, 0, 19);
  syscall(SYS_ioprio_set, kWhoProcess, 0, kIdleClass);
}

std::string expectationOf(const std::string& name, const KeyframeGraph& keyframes) {
  std::size_t points = 0;
  for (int id = 0; id < keyframes.size(); ++id) points += keyframes.scan(id)->points.size();
  const double megabytes =
      kProgram +
      kCopies * 1e-6 * (static_cast<double>(points * sizeof(Keyframe::Point)) + kBytesPerKeyframe * keyframes.size());
  char text[200];
  std::snprintf(text, sizeof text, "map %s: %d keyframes; this takes about %.0f s and %.0f MB of memory", name.c_str(),
                keyframes.size(), std::ceil(kSecondsPerKeyframe * keyframes.size()), megabytes);
  return text;
}

}  // namespace

std::string StoredRefinement::carryOut(const std::function<void(const std::string&)>& announce,
                                       const std::function<void(double)>& progress) const {
  const StoredMap map{directory, name, grid};
  if (!refined.empty()) requireFreeName(directory, refined);
  const LoadedMap before = loadWhole(directory, name, grid);
  try {
    if (refined.empty()) map.requireUnused();
    if (announce) announce(expectationOf(name, before.state.keyframes));
    yieldToOthers();
    const RefinedMap result = refineMap(before.state, back_end, grid, {}, [&](double share) {
      if (progress) progress(kComputed * share);
    });
    if (result.map) refined.empty() ? map.replaceBy(before, *result.map) : storeNew(directory, refined, *result.map);
    return wordsOf(result.report, name, refined);
  } catch (const FolderLocked&) {
    throw std::runtime_error("slamd has map " + name + " open; slamctl load another one first, or give --as");
  }
}

}  // namespace slam
