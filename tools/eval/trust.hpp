// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <Eigen/Core>
#include <filesystem>
#include <optional>
#include <vector>

#include "core/estimates.hpp"
#include "tools/common/trajectory.hpp"

namespace slam {

/// A row of slam-replay --estimates: what the robot knew when it had used a scan.
struct KnownPose {
  Timestamp stamp;
  LocalisationState state = LocalisationState::kInitialising;
  Pose2 T_map_base;
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();  ///< of (x, y, theta) in map [m, m, rad]
};

/// Columns are found by their names. @throws std::runtime_error with file and line
std::vector<KnownPose> readEstimates(const std::filesystem::path& file);

struct TrustOptions {
  double align_seconds = 2.0;  ///< [s] of the first localised scans by which map is laid on the truth; 0: it lies there
  double settling = 10.0;      ///< [s] in which a robot may be initialising
  std::optional<double> kidnapped = {};  ///< [s] behind the first scan: from here on it is to be lost, or right again
};

/// Whether the robot knew how well it knew its pose. A pose is *wrong* if its position is off by more than three
/// standard deviations in the error's direction and 3 cm, or its heading by more than three and 0.5 degrees.
struct TrustErrors {
  int scans = 0, left_out = 0;    ///< left out: outside the truth's time
  int localised = 0;              ///< scans in that state
  int wrong = 0;                  ///< of these
  int settled = 0;                ///< scans behind the settling
  int needless = 0;               ///< of these, lost or initialising though within 0.10 m
  double worst = 0.0;             ///< [m] position error of a localised scan
  double nees = 0.0;              ///< mean of e^T P^-1 e over the localised scans; 3 where covariances are right
  std::optional<double> noticed;  ///< [s] from the kidnapping to the first scan that is not localised, or not wrong

  double sureAndWrong() const { return localised > 0 ? static_cast<double>(wrong) / localised : 0.0; }
  double needlesslyLost() const { return settled > 0 ? static_cast<double>(needless) / settled : 0.0; }
};
TrustErrors trustErrors(const std::vector<KnownPose>& estimates, const Trajectory& truth, const TrustOptions& options);

}  // namespace slam
