// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <cmath>
#include <fstream>
#include <optional>
#include <slam/health_t.hpp>
#include <slam/pose_estimate_t.hpp>
#include <sstream>
#include <string>
#include <vector>

#include "bus/channels.hpp"
#include "integration/live.hpp"
#include "tools/common/trajectory.hpp"

namespace slam::test {

/// Of a device, as part of a test's name.
inline std::string nameOf(std::string device) {
  std::erase(device, '-');
  return device;
}

/// slamd as a user runs it, whose devices fail when a test says so.
class LiveFaults : public Live {
 protected:
  /// States by number, as pose_estimate_t and device_health_t have them.
  static constexpr int kLocalised = 1, kDegraded = 2, kLost = 3;
  static constexpr int kStreaming = 2;

  struct SeenPose {
    Timestamp stamp;
    Pose2 pose;  // of base in map
    int state;
  };

  /// @param faults lines for slam-sim's fault pipe, after the device's name, with semicolons between
  void inject(const std::string& device, const std::string& faults) const {
    std::istringstream lines(faults);
    std::ofstream pipe(folder_ / "devices" / "faults");
    for (std::string line; std::getline(lines, line, ';');) pipe << device << " " << line << std::endl;
  }
  std::optional<device_health_t> device(const std::string& name) {
    const auto health = listener_.last<health_t>(channel::kHealth);
    if (!health) return std::nullopt;
    for (const device_health_t& d : health->devices) {
      if (d.name == name) return d;
    }
    return std::nullopt;
  }
  bool streams(const std::string& name) {
    const auto d = device(name);
    return d && d->state == kStreaming && d->age >= 0.0 && d->age < 1.0;
  }
  bool isWell(const std::string& name) {
    const auto d = device(name);
    return d && d->state == kStreaming && d->reason.empty();
  }
  std::string summary() {
    const auto health = listener_.last<health_t>(channel::kHealth);
    return health ? health->summary : "";
  }
  /// @return the localisation state now, 0 before there is one; the pose is kept for compare()
  int poseState() {
    const auto estimate = listener_.last<pose_estimate_t>(channel::kSlamPose);
    if (!estimate) return 0;
    const auto lidar = device("lidar");
    lidar_ailed_ |= lidar && !lidar->reason.empty();
    const Timestamp stamp{Duration(1000 * estimate->utime)};
    if (poses_.empty() || poses_.back().stamp != stamp) {
      poses_.push_back({stamp, {estimate->x, estimate->y, estimate->theta}, estimate->state});
    }
    return estimate->state;
  }
  /// Listens for so long. @return the worst localisation state meanwhile
  int worstStateFor(std::chrono::milliseconds time) {
    int worst = 0;
    listener_.until([&] { return worst = std::max(worst, poseState()), false; }, time);
    return worst;
  }

  /// Ends the simulated drive, so that its truth can be read.
  Trajectory endDrive() {
    sim_->signal(SIGTERM);
    EXPECT_EQ(sim_->wait(10s), 0) << simulatorLog();
    return readTrajectory(folder_ / "truth.tum");
  }
  struct Compared {
    double worst = 0.0;  // [m] distance from the truth
    int poses = 0;
  };
  /// Poses kept in [begin, end) that are of that state, with the truth; map and world are one at the first pose.
  Compared compare(const Trajectory& truth, std::size_t begin, std::size_t end, int state) const {
    const auto first =
        std::find_if(poses_.begin(), poses_.end(), [](const SeenPose& seen) { return seen.state == kLocalised; });
    Compared compared;
    const auto anchor = first == poses_.end() ? std::nullopt : poseAt(truth, first->stamp);
    if (!anchor) return compared;
    const Pose2 T_map_world = first->pose * anchor->inverse();
    for (std::size_t i = begin; i < end; ++i) {
      const auto at = poseAt(truth, poses_[i].stamp);
      if (!at || poses_[i].state != state) continue;
      const Pose2 expected = T_map_world * *at;
      compared.worst = std::max(compared.worst, (expected.translation() - poses_[i].pose.translation()).norm());
      ++compared.poses;
    }
    return compared;
  }

  Listener listener_;
  std::vector<SeenPose> poses_;
  bool lidar_ailed_ = false;  // at one of the looks at the pose
};

}  // namespace slam::test
