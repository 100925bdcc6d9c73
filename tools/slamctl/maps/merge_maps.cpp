// SPDX-License-Identifier: BSD-3-Clause
#include "tools/slamctl/maps/merge_maps.hpp"

#include <cstdio>
#include <numbers>
#include <stdexcept>

#include "mapping/map_files.hpp"
#include "problems/answer.hpp"
#include "problems/answers.hpp"
#include "store/map_folders.hpp"
#include "store/map_store.hpp"
#include "tools/slamctl/maps/stored_map.hpp"

namespace slam {
namespace {

using Outcome = MergeReport::Outcome;

std::string placeText(const Pose2& T_first_second) {
  char text[80];
  std::snprintf(text, sizeof text, "x %.2f m, y %.2f m, turned by %.1f deg", T_first_second.x, T_first_second.y,
                T_first_second.theta * 180.0 / std::numbers::pi);
  return text;
}

/// Both places, each with the path of the second map.
void writePictures(const StoredMerge& merge, const MapState& first, const MapState& second,
                   const RegisteredMap& registration) {
  int number = 0;
  for (const Pose2& T_first_second : {registration.T_map_second, registration.T_map_other}) {
    const MapState joint = jointMap(first, second, T_first_second, merge.grid);
    std::vector<Eigen::Vector2d> path;
    for (int id = first.keyframes.size(); id < joint.keyframes.size(); ++id)
      path.push_back(joint.keyframes.pose(id).translation());
    writeMapFiles(merge.pictures + "-" + std::to_string(++number), renderMap(joint.grid), path);
  }
}

/// Why two maps were not merged.
std::string refusalOf(const StoredMerge& merge, const MergeReport& report) {
  const RegisteredMap& registration = report.registration;
  const auto number = [](std::size_t n) { return std::to_string(n); };
  switch (report.outcome) {
    case Outcome::kMerged:
    case Outcome::kOtherFurniture:  // a row of the table
      break;
    case Outcome::kNoKeyframes:
      return "one of the maps has no keyframes: it is a floor plan, or empty";
    case Outcome::kShared:
      return merge.second + " holds keyframes of " + merge.first + ": it is a copy of it, or was made from it";
    case Outcome::kTooManyEdits:
      return "together the maps have more edits than a map may have; remove some";
    case Outcome::kNowhere:
      return merge.second + " was not found in " + merge.first + ": " + number(registration.found.size()) + " of " +
             std::to_string(registration.stretches) +
             " stretches of its path have a place there; drive through more of what both maps show";
    case Outcome::kAmbiguous:
      return "two places of " + merge.first + " fit " + merge.second + ": " + placeText(registration.T_map_second) +
             ", and " + placeText(registration.T_map_other) +
             (merge.pictures.empty() ? "; --pictures PREFIX draws them"
                                     : "; see " + merge.pictures + "-1.png and -2.png");
    case Outcome::kContradictory:
      return merge.second + " contradicts " + merge.first + ": " + number(registration.found.size()) +
             " stretches of its path have one place, " + std::to_string(registration.elsewhere) + " another; " +
             std::to_string(report.verified - report.revoked) + " of " + std::to_string(report.near) +
             " keyframes match there";
  }
  return "";
}

std::string summaryOf(const StoredMerge& merge, const MergeReport& report, int first, int second) {
  const RegisteredMap& registration = report.registration;
  std::string moved;
  if (report.furniture.found() > 0.0) {
    char outline[120];
    std::snprintf(outline, sizeof outline,
                  "; of the others' outlines %.1f m look like pieces that were moved, %.1f m do not",
                  report.furniture.found(), report.furniture.other);
    moved = outline;
  }
  char text[700];
  std::snprintf(
      text, sizeof text,
      "map %s: %d keyframes of %s and %d of %s, which lies at %s\n"
      "overlap %.0f %% of what %s shows, of which %.0f %% agrees; residual %.3f m\n"
      "%.1f %% of the occupied cells that both maps have seen are the same%s\n"
      "found: %zu of %d stretches of its path by themselves, %d elsewhere; %d of %d keyframes match, %d of them "
      "revoked\n"
      "log-likelihood over any other place %.0f, of which %.0f would do",
      merge.merged.c_str(), first, merge.first.c_str(), second, merge.second.c_str(),
      placeText(registration.T_map_second).c_str(), 100.0 * registration.overlap, merge.second.c_str(),
      100.0 * registration.agreement, report.residual, 100.0 * report.cells.share(), moved.c_str(),
      registration.found.size(), registration.stretches, registration.elsewhere, report.verified, report.near,
      report.revoked, registration.margin, registration.needed);
  return text;
}

}  // namespace

std::string StoredMerge::carryOut(const std::function<void(double)>& progress) const {
  if (first == second) throw std::runtime_error("map " + first + " cannot be merged with itself");
  requireFreeName(directory, merged);
  const MapState one = loadWhole(directory, first, grid).state, other = loadWhole(directory, second, grid).state;
  MergeConfig config;
  config.furniture_moved = furniture_moved;
  const MergedMap result = mergeMaps(one, other, back_end, grid, config, progress);
  if (result.report.outcome == Outcome::kOtherFurniture)
    throw CommandRefused({answer::kOtherFurniture,
                          {100.0 * result.report.cells.share(), 100.0 * config.min_same_cells,
                           result.report.furniture.found(), result.report.furniture.other},
                          {first, second}});
  if (!result.map) {
    if (result.report.outcome == Outcome::kAmbiguous && !pictures.empty())
      writePictures(*this, one, other, result.report.registration);
    throw std::runtime_error(refusalOf(*this, result.report));
  }
  storeNew(directory, merged, *result.map);
  return summaryOf(*this, result.report, one.keyframes.size(), other.keyframes.size());
}

}  // namespace slam
