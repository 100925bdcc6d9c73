// SPDX-License-Identifier: BSD-3-Clause
// Does the pose filter know how wrong it is? Simulated drives through the pipeline, against the truth.
#include <filesystem>
#include <gtest/gtest.h>

#include "build_paths.hpp"
#include "bus/channels.hpp"
#include "bus/checked_decode.hpp"
#include "bus/event_log.hpp"
#include "bus/messages.hpp"
#include "config/loader.hpp"
#include "frontend/front_end.hpp"
#include "support/consistency.hpp"
#include "tools/common/trajectory.hpp"
#include "tools/sim/log_mode.hpp"

namespace slam::sim::covariance_test {
namespace {

namespace fs = std::filesystem;

constexpr std::uint64_t kSeeds = 4;
constexpr double kOverconfident = 1.5, kPessimistic = 0.05, kWithin95 = 0.90;

struct Compared {
  PoseEstimate estimate;
  Pose2 truth;
};

/// Estimates at the scans that were fused, from the drive's begin on.
std::vector<Compared> drive(const std::string& scene, std::uint64_t seed, double seconds,
                            const Situation& situation = {}) {
  const fs::path folder = fs::path(testing::TempDir()) / ("covariance_" + std::to_string(getpid()));
  const fs::path log_file = folder / "log.lcm", truth_file = folder / "truth.tum";
  fs::create_directories(folder);
  writeLog({.scene = scene, .seed = seed, .seconds = seconds, .situation = situation, .truth = truth_file}, log_file);
  const Trajectory truth = readTrajectory(truth_file);
  FrontEnd front_end(loadConfig(SLAMD_SIM_CONFIG).front_end);
  std::vector<Compared> drive;
  EventLogReader log(log_file);
  for (LogEvent event; log.next(event);) {
    if (event.channel == channel::kWheels) {
      front_end.add(fromMessage(decodeChecked<wheels_t>(event.data).value()).value());
    } else if (event.channel == channel::kImu) {
      front_end.add(fromMessage(decodeChecked<imu_t>(event.data).value()).value());
    } else if (event.channel == channel::kScan) {
      const ScanOutcome outcome = front_end.add(fromMessage(decodeChecked<scan_t>(event.data).value()).value());
      const auto true_pose = poseAt(truth, outcome.first);  // known for the scans' own stamps
      if (!outcome.fused || !true_pose) continue;
      PoseEstimate estimate = front_end.estimate(outcome.stamp);
      estimate.T_map_base = estimate.T_map_base * outcome.T_base_first;
      drive.push_back({estimate, *true_pose});
    }
  }
  fs::remove_all(folder);
  return drive;
}

/// Motion between two instants of one drive. What the two poses have in common - the map's own error - drops out of
/// it, so their covariances may be added as if they were independent.
void addMotion(const Compared& from, const Compared& to, test::Consistency& consistency) {
  const Pose2 &a = from.estimate.T_map_base, &b = to.estimate.T_map_base;
  const BinaryJacobians J = betweenJacobians(a, b);
  const Eigen::Matrix3d covariance = J.first * from.estimate.covariance * J.first.transpose() +
                                     J.second * to.estimate.covariance * J.second.transpose();
  consistency.add(between(a, b), between(from.truth, to.truth), covariance);
}

void expectHonest(const char* what, const test::Consistency& consistency) {
  SCOPED_TRACE(what);
  testing::Test::RecordProperty(std::string(what) + "_nees_per_degree", std::to_string(consistency.ratio()));
  testing::Test::RecordProperty(std::string(what) + "_within_95", std::to_string(consistency.shareWithin95()));
  EXPECT_LT(consistency.ratio(), kOverconfident);
  EXPECT_GT(consistency.ratio(), kPessimistic);
  EXPECT_GE(consistency.shareWithin95(), kWithin95);
}

struct Route {
  const char* name;
  const char* scene;
  double seconds;
};

class FilterCovariance : public testing::TestWithParam<Route> {};

TEST_P(FilterCovariance, CoversTheMotionOfTheNextSecond) {
  constexpr std::size_t kScans = 5;  // a second, 0.2 to 0.5 m
  test::Consistency next_scan, next_second;
  for (std::uint64_t seed = 1; seed <= kSeeds; ++seed) {
    const std::vector<Compared> estimates = drive(GetParam().scene, seed, GetParam().seconds);
    ASSERT_GT(estimates.size(), 5.0 * GetParam().seconds);
    for (std::size_t i = kScans; i < estimates.size(); ++i) {
      addMotion(estimates[i - 1], estimates[i], next_scan);
      addMotion(estimates[i - kScans], estimates[i], next_second);
    }
  }
  expectHonest("next_scan", next_scan);
  expectHonest("next_second", next_second);
}

INSTANTIATE_TEST_SUITE_P(Drives, FilterCovariance,
                         testing::Values(Route{"MeetingRoom", "meeting-room", 60.0},
                                         Route{"Corridor40m", "corridor-loop", 82.0}),
                         [](const auto& test) { return std::string(test.param.name); });

// Where all that is seen was mapped from the start, map and world are one, and the pose itself can be compared. Later
// the map drifts, and the covariance, which is relative to the map, does not say so.
TEST(FilterCovarianceAtFirst, CoversThePoseInTheFirstView) {
  test::Consistency consistency;
  for (const char* scene : {"meeting-room", "corridor-loop"}) {
    for (std::uint64_t seed = 1; seed <= 2 * kSeeds; ++seed) {
      for (const Compared& at : drive(scene, seed, 8.0)) {
        consistency.add(at.estimate.T_map_base, at.truth, at.estimate.covariance);
      }
    }
  }
  expectHonest("pose", consistency);
}

// Ranges that are all too long bend the walls of a hall, each scan a little more: no mean over scans lessens that.
TEST(FilterCovarianceOfALidarThatIsOff, CoversThePoseSinceTheMapBegan) {
  Situation too_long;
  addTo(too_long, "range-bias=0.02");
  for (const char* scene : {"hall", "meeting-room"}) {
    test::Consistency consistency;
    for (std::uint64_t seed = 1; seed <= 3; ++seed) {
      for (const Compared& at : drive(scene, seed, 100.0, too_long)) {
        consistency.add(at.estimate.T_map_base, at.truth, at.estimate.covariance);
      }
    }
    SCOPED_TRACE(scene);
    testing::Test::RecordProperty(std::string(scene) + "_nees_per_degree", std::to_string(consistency.ratio()));
    EXPECT_LT(consistency.ratio(), kOverconfident);
    EXPECT_GT(consistency.ratio(), 0.25) << "the mount is considered, too, though it is right here";
  }
}

}  // namespace
}  // namespace slam::sim::covariance_test
