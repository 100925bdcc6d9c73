// SPDX-License-Identifier: BSD-3-Clause
#include "app/log/storage_watch.hpp"

namespace slam {
namespace {

using namespace std::chrono_literals;
constexpr Duration kDiskHangs = 3s;  // in one piece of work

}  // namespace

std::vector<Trouble> StorageWatch::troubles(Timestamp now) const {
  std::vector<Trouble> troubles;
  for (const Stored& stored : stored_) {
    const StorageReport report = stored.report(now);
    const std::string name = stored.name;
    const StorageProblem& fails = report.problem;
    if (fails.problem) {
      troubles.push_back({.device = name,
                          .problem = fails.problem,
                          .begin = name + (fails.since.empty() ? ": " : " "),
                          .since = fails.since,
                          .meanwhile = fails.meanwhile,
                          .recovery = name + ": the disk takes it again",
                          .error = true,
                          .fault = true});
    }
    if (report.lost)
      troubles.push_back({.device = name, .problem = report.lost, .begin = name + ": ", .besides = true});
    if (report.waiting <= kDiskHangs) continue;
    troubles.push_back({.device = name,
                        .problem = {problem::kDiskHangs, {toSeconds(report.waiting)}},
                        .begin = name + ": ",
                        .recovery = name + ": the disk answers again",
                        .besides = true});
  }
  return troubles;
}

}  // namespace slam
