// SPDX-License-Identifier: BSD-3-Clause
#include "tools/slamctl/setup/drive_calibration.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>
#include <ostream>
#include <stdexcept>

#include "tools/calibrate/gyro_scale.hpp"
#include "tools/calibrate/misfit.hpp"
#include "tools/calibrate/motion_selection.hpp"
#include "tools/calibrate/sensor_log.hpp"
#include "tools/common/program.hpp"

namespace slam {
namespace {

using Index = RobotGeometry::Index;

constexpr double kInterval = 1.96;       // sigmas, 95 %
constexpr int kMostPasses = 3;           // over the log
constexpr double kMoved = 0.005;         // [m] of the lidar: the log is matched anew
constexpr double kTurned = 0.005;        // [rad] the same
constexpr double kMinScaleStep = 0.002;  // [1] of radius or track: less is of no matter
constexpr double kMinStep = 0.003;       // [m] of the lidar's place: the same
constexpr double kMinTurn = 0.003;       // [rad] of its yaw: the same
constexpr double kReversed = -0.5;       // [1] scale of a gyro that is upside down

RobotGeometry geometryOf(const Config& config) {
  const DifferentialBase& base = config.base_device.geometry;
  return {base.wheel_radius, base.wheel_radius, 2.0 * base.half_track, config.front_end.lidar.T_base_lidar};
}

/// As the configuration can have it: both wheels of one radius.
Config withGeometry(Config config, const Calibration& result) {
  const RobotGeometry& found = result.geometry;
  DifferentialBase& base = config.base_device.geometry;
  Pose2& lidar = config.front_end.lidar.T_base_lidar;
  const auto& known = result.determined;
  if (known[Index::kLeftRadius] && known[Index::kRightRadius])
    base.wheel_radius = 0.5 * (found.left_radius + found.right_radius);
  if (known[Index::kTrack]) base.half_track = 0.5 * found.track;
  if (known[Index::kLidarX]) lidar.x = found.T_base_lidar.x;
  if (known[Index::kLidarY]) lidar.y = found.T_base_lidar.y;
  if (known[Index::kLidarYaw]) lidar.theta = found.T_base_lidar.theta;
  return config;
}

/// @param matters [unit] less of it is of no matter
CalibratedValue valueOf(const char* key, const char* unit, double configured, double estimated, double sigma,
                        double matters) {
  constexpr double kPerUnit = 1e5;  // digits that a person reads
  const double off = std::abs(estimated - configured), interval = kInterval * sigma;
  return {
      key, unit, configured, std::round(kPerUnit * estimated) / kPerUnit, interval, off > interval && off > matters};
}

std::vector<CalibratedValue> valuesOf(const Config& before, const Config& after, const Calibration& result) {
  const DifferentialBase &base = before.base_device.geometry, &found = after.base_device.geometry;
  const Pose2 &lidar = before.front_end.lidar.T_base_lidar, &place = after.front_end.lidar.T_base_lidar;
  const auto& cov = result.covariance;
  constexpr auto kLeft = Index::kLeftRadius, kRight = Index::kRightRadius;
  const double radius_sigma = 0.5 * std::sqrt(cov(kLeft, kLeft) + cov(kRight, kRight) + 2.0 * cov(kLeft, kRight));
  const auto& known = result.determined;
  std::vector<CalibratedValue> values;
  if (known[kLeft] && known[kRight])
    values.push_back(valueOf("base.wheel_radius", "m", base.wheel_radius, found.wheel_radius, radius_sigma,
                             kMinScaleStep * base.wheel_radius));
  if (known[Index::kTrack])
    values.push_back(valueOf("base.half_track", "m", base.half_track, found.half_track,
                             0.5 * result.sigma(Index::kTrack), kMinScaleStep * base.half_track));
  if (known[Index::kLidarX])
    values.push_back(valueOf("lidar.x", "m", lidar.x, place.x, result.sigma(Index::kLidarX), kMinStep));
  if (known[Index::kLidarY])
    values.push_back(valueOf("lidar.y", "m", lidar.y, place.y, result.sigma(Index::kLidarY), kMinStep));
  if (known[Index::kLidarYaw])
    values.push_back(valueOf("lidar.yaw", "rad", lidar.theta, place.theta, result.sigma(Index::kLidarYaw), kMinTurn));
  return values;
}

/// The config's numbers, where they are wrong.
void setWrong(Config& config, const std::vector<CalibratedValue>& values) {
  DifferentialBase& base = config.base_device.geometry;
  Pose2& lidar = config.front_end.lidar.T_base_lidar;
  const std::pair<std::string_view, double*> numbers[] = {{"base.wheel_radius", &base.wheel_radius},
                                                          {"base.half_track", &base.half_track},
                                                          {"lidar.x", &lidar.x},
                                                          {"lidar.y", &lidar.y},
                                                          {"lidar.yaw", &lidar.theta},
                                                          {"imu.roll", &config.imu_device.roll}};
  for (const CalibratedValue& value : values) {
    for (const auto& [key, number] : numbers) {
      if (value.is_wrong && key == value.key) *number = value.estimated;
    }
  }
}

struct Rms {
  double translation = 0.0, rotation = 0.0;
};
/// Of those motions that fit the calibrated geometry best: no slip is among them.
Rms rmsOf(const RobotGeometry& geometry, const RobotGeometry& calibrated, std::span<const LidarMotion> motions,
          int used) {
  const std::vector<Misfit> misfit = misfits(calibrated, motions);
  std::vector<std::size_t> order(motions.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::sort(order.begin(), order.end(), [&](auto a, auto b) { return misfit[a].all < misfit[b].all; });
  order.resize(std::min(order.size(), static_cast<std::size_t>(used)));
  Rms rms;
  for (const std::size_t i : order) {
    const Eigen::Vector3d off = residual(geometry, motions[i]);
    rms.translation += off.head<2>().squaredNorm() / static_cast<double>(order.size());
    rms.rotation += off.z() * off.z() / static_cast<double>(order.size());
  }
  return {std::sqrt(rms.translation), std::sqrt(rms.rotation)};
}

void refuse(const Calibration& result) {
  if (result.status == CalibrationStatus::kTooFew)
    throw std::runtime_error("the robot drove too little: " + std::to_string(result.used) +
                             " motions of decimetres with matched scans; drive for a minute, straight and turning both "
                             "ways");
  if (result.status == CalibrationStatus::kContradicted)
    throw std::runtime_error(
        "wheels and lidar contradict each other in too many motions; check that wheel radius and track are about "
        "right, which wheel is the left one, the wheels' signs, and lidar.upside_down");
}

void takeGyro(const Config& config, const SensorLog& log, DriveCalibration& result) {
  const auto scale = gyroScale(log);
  if (!scale) return;
  result.gyro_scale = scale->value;
  result.gyro_interval = kInterval * scale->sigma;
  // A program that sends it over LCM has to turn it itself.
  if (scale->value > kReversed || config.imu_device.driver == ImuDriver::kLcm) return;
  const double roll = config.imu_device.roll;
  result.values.push_back({"imu.roll", "rad", roll, roll > 0.0 ? 0.0 : std::numbers::pi, 0.0, true});
}

}  // namespace

DriveCalibration calibrateDrive(Config& config, const std::filesystem::path& log) {
  Config working = config;
  Calibration result;
  std::vector<LidarMotion> motions;
  SensorLog seen;
  for (int pass = 0; pass < kMostPasses; ++pass) {
    showProgress("matching the scans of the drive, pass " + std::to_string(pass + 1));
    seen = readSensorLog(working, log);
    const RobotGeometry before = geometryOf(working);
    motions = selectMotions(seen, before);
    result = calibrate(motions, before);
    endProgress();
    refuse(result);
    working = withGeometry(working, result);
    const Pose2 moved = between(before.T_base_lidar, working.front_end.lidar.T_base_lidar);
    if (moved.translation().norm() < kMoved && std::abs(moved.theta) < kTurned) break;
  }
  DriveCalibration drive{
      .values = valuesOf(config, working, result), .open = {}, .used = result.used, .rejected = result.rejected};
  if (result.status == CalibrationStatus::kPartly) drive.open = describe(result.drive);
  takeGyro(config, seen, drive);
  const Rms before = rmsOf(geometryOf(config), result.geometry, motions, result.used);
  setWrong(config, drive.values);
  const Rms after = rmsOf(geometryOf(config), result.geometry, motions, result.used);
  drive.translation_before = before.translation;
  drive.translation_after = after.translation;
  drive.rotation_before = before.rotation;
  drive.rotation_after = after.rotation;
  return drive;
}

void print(const DriveCalibration& drive, std::ostream& out) {
  char line[160];
  const auto put = [&](const char* format, auto... values) {
    std::snprintf(line, sizeof line, format, values...);
    out << line << "\n";
  };
  constexpr double kDegree = std::numbers::pi / 180.0;
  put("%d motions used, %d rejected", drive.used, drive.rejected);
  put("%-20s %11s %11s   %-18s", "key", "configured", "estimated", "95 % interval");
  for (const CalibratedValue& value : drive.values)
    put("%-20s %11.5f %11.5f   +- %.5f %-4s   %s", value.key, value.configured, value.estimated, value.interval,
        value.unit, value.is_wrong ? "wrong, changed" : "right, stays");
  if (drive.gyro_scale != 0.0)
    put("%-20s %11.5f %11.5f   +- %.5f        gyro's turns over the scans'", "(gyro)", 1.0, drive.gyro_scale,
        drive.gyro_interval);
  put("error of scans over wheels, per motion: %.1f mm, %.3f deg before; %.1f mm, %.3f deg after",
      1e3 * drive.translation_before, drive.rotation_before / kDegree, 1e3 * drive.translation_after,
      drive.rotation_after / kDegree);
  if (!drive.open.empty()) out << "The other values are not determined by this drive: " << drive.open << ".\n";
}

}  // namespace slam
