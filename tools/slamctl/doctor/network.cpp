// SPDX-License-Identifier: BSD-3-Clause
#include <atomic>

#include "drivers/lidar/search/lidar_search.hpp"
#include "tools/slamctl/doctor.hpp"

namespace slam {

Finding checkTcpLidar(const std::string& driver, const std::string& path, const PortOpener& open, Timestamp (*now)()) {
  const std::atomic<bool> never{false};
  const LidarFinding found = LidarSearch(path, 0, open, now).ask(never);
  const char* word = found.family == LidarFinding::kHokuyo ? "hokuyo"
                     : found.family == LidarFinding::kSick ? "sick"
                                                           : nullptr;
  if (word == nullptr) {
    const Problem problem = found.is_open ? Problem(problem::kTcpSilent, {}, {path}) : found.problem;
    return {Finding::kFault, "lidar: " + problem.cause(), problem.fix()};
  }
  if (driver != word && driver != "auto")
    return {Finding::kFault, "lidar: " + path + " answers as a lidar of lidar.driver = \"" + word + "\"",
            std::string("set lidar.driver = \"") + word + "\", or the lidar.port of the other one"};
  return {Finding::kGood, "lidar: " + path + " answers", ""};
}

}  // namespace slam
