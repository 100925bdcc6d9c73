// SPDX-License-Identifier: BSD-3-Clause
#include "tools/common/refinement_words.hpp"

#include <cstdio>

namespace slam {

std::string wordsOf(const RefineReport& report, const std::string& name, const std::string& stored) {
  using Outcome = RefineReport::Outcome;
  const std::string kept = "map " + name + " is kept as it was: ";
  if (report.outcome == Outcome::kNoKeyframes) return kept + "with fewer than two keyframes there is nothing to refine";
  if (report.outcome == Outcome::kFloorPlan) return kept + "it is a floor plan, which has no scans";
  if (report.outcome == Outcome::kNoRevisits) return kept + "too little of it was seen on two visits to be measured";
  char text[600];
  std::snprintf(text, sizeof text,
                "%-38s %9s %9s\n%-38s %7.1f mm %7.1f mm\n%-38s %7.1f mm %7.1f mm\n%-38s %7.1f mm %7.1f mm\n"
                "%d of %d pairs of visits match, %d of them revoked\n",
                "", "before", "after", "thickness of the walls, RMS", 1e3 * report.before.wall_thickness,
                1e3 * report.after.wall_thickness, "revisits are off by, RMS", 1e3 * report.before.revisits,
                1e3 * report.after.revisits, "closures held back are off by, RMS", 1e3 * report.before.held_back,
                1e3 * report.after.held_back, report.verified, report.compared, report.revoked);
  if (report.outcome == Outcome::kNoBetter) return text + kept + "the figures do not fall";
  return text + ("map " + name + " is refined" + (stored.empty() ? "" : ", stored as " + stored));
}

}  // namespace slam
