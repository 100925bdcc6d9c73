// SPDX-License-Identifier: BSD-3-Clause
#include "app/log/storage_watch.hpp"

#include <cmath>
#include <string_view>

namespace slam {
namespace {

using namespace std::chrono_literals;
constexpr Duration kDiskHangs = 3s;  // in one piece of work
constexpr std::string_view kNotWritten = "not written ";

}  // namespace

std::vector<Trouble> StorageWatch::troubles(Timestamp now) const {
  std::vector<Trouble> troubles;
  for (const Stored& stored : stored_) {
    const StorageReport report = stored.report(now);
    const std::string name = stored.name;
    if (!report.problem.empty()) {
      troubles.push_back({.cause = name,
                          .text = name + (report.problem.starts_with(kNotWritten) ? " " : ": ") + report.problem,
                          .recovery = name + ": the disk takes it again",
                          .error = true});
    }
    if (!report.lost.empty())
      troubles.push_back({.cause = name + " gaps", .text = name + ": " + report.lost, .recovery = ""});
    if (report.waiting <= kDiskHangs) continue;
    troubles.push_back({.cause = name + " disk",
                        .text = name +
                                ": the disk does not answer, slamd goes on and writes what is new when it does; is it "
                                "broken, or too slow? (" +
                                std::to_string(std::lround(toSeconds(report.waiting))) + " s so far)",
                        .recovery = name + ": the disk answers again"});
  }
  return troubles;
}

}  // namespace slam
