// SPDX-License-Identifier: BSD-3-Clause
// The input is a byte that chooses what slam-eval compares, the length of its first file, that file and the second one.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <stdexcept>
#include <string>

#include "fuzz/fuzzing.hpp"
#include "fuzz/memory_file.hpp"
#include "tools/common/trajectory.hpp"
#include "tools/eval/metrics.hpp"
#include "tools/eval/trust.hpp"

namespace slam {
namespace {

enum Comparison : std::uint8_t { kTrajectories, kRelations, kEstimates, kComparisons };

using fuzz::textOf;

/// A file, and how many rows it can have.
struct File {
  fuzz::MemoryFile file = {};
  int lines = 0;

  void write(fuzz::Bytes bytes) {
    file.write(textOf(bytes));
    lines = static_cast<int>(std::count(bytes.begin(), bytes.end(), '\n')) + 1;
  }
  /// No row comes from nowhere.
  template <typename Rows>
  Rows read(Rows (*reader)(const std::filesystem::path&)) const {
    Rows rows = reader(file.path());
    FUZZ_CHECK(!rows.empty() && rows.size() <= static_cast<std::size_t>(lines));
    return rows;
  }
};

/// Stamps that were read are written and read again as they were, to the microsecond, and in the same order.
void checkWritten(const Trajectory& trajectory) {
  static const fuzz::MemoryFile file;
  file.write("");
  TrajectoryWriter writer(file.path());
  const auto utimeOf = [](Timestamp stamp) { return toMicroseconds(stamp); };
  for (const StampedPose& row : trajectory) writer.write(utimeOf(row.stamp), row.pose);
  writer.close();
  const Trajectory again = readTrajectory(file.path());
  FUZZ_CHECK(again.size() == trajectory.size());
  for (std::size_t i = 0; i < again.size(); ++i) FUZZ_CHECK(utimeOf(again[i].stamp) == utimeOf(trajectory[i].stamp));
}

void checkTrajectory(const Trajectory& trajectory) {
  for (std::size_t i = 0; i < trajectory.size(); ++i) {
    FUZZ_CHECK(i == 0 || trajectory[i - 1].stamp <= trajectory[i].stamp);
    FUZZ_CHECK(std::abs(trajectory[i].pose.theta) <= 3.15);
    FUZZ_CHECK(poseAt(trajectory, trajectory[i].stamp).has_value());
  }
  FUZZ_CHECK_NO_THROW((checkWritten(trajectory), true));
}

void checkComparison(Comparison comparison, const File& first, const File& second) {
  if (comparison == kEstimates) {
    const auto estimates = first.read(readEstimates);
    const auto truth = second.read(readTrajectory);
    const TrustErrors errors = trustErrors(estimates, truth, {.kidnapped = 1.0});
    FUZZ_CHECK(errors.scans + errors.left_out == static_cast<int>(estimates.size()));
    FUZZ_CHECK(errors.wrong <= errors.localised && errors.localised <= errors.scans);
    FUZZ_CHECK(errors.needless <= errors.settled && errors.settled <= errors.scans);
    return;
  }
  const auto trajectory = first.read(readTrajectory);
  checkTrajectory(trajectory);
  const int rows = static_cast<int>(trajectory.size());
  if (comparison == kRelations) {
    const auto relations = second.read(readRelations);
    const RelationErrors errors = relationErrors(trajectory, relations);
    FUZZ_CHECK(errors.used + errors.left_out == static_cast<int>(relations.size()));
    return;
  }
  const auto truth = second.read(readTrajectory);
  const AteErrors errors = absoluteErrors(trajectory, truth);
  FUZZ_CHECK(errors.used + errors.left_out == rows);
  const WaypointErrors waypoints = waypointErrors(trajectory, truth);
  FUZZ_CHECK(waypoints.position.size() == waypoints.heading.size());
  FUZZ_CHECK(waypoints.position.size() + static_cast<std::size_t>(waypoints.left_out) == truth.size());
}

}  // namespace
}  // namespace slam

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace slam;
  static File first, second;
  fuzz::Input input({data, size});
  const auto comparison = static_cast<Comparison>(input.take<std::uint8_t>() % kComparisons);
  first.write(input.takeBytes(input.take<std::uint16_t>()));
  second.write(input.rest());
  try {
    checkComparison(comparison, first, second);
  } catch (const std::runtime_error& error) {  // refused, by the file's name and mostly the line
    FUZZ_CHECK(std::string(error.what()).starts_with("/proc/self/fd/"));
  }
  return 0;
}
