// SPDX-License-Identifier: BSD-3-Clause
#include <CLI/App.hpp>
#include <cstdio>
#include <iostream>

#include "config/loader.hpp"
#include "tools/calibrate/calibration.hpp"
#include "tools/calibrate/motion_selection.hpp"
#include "tools/calibrate/report.hpp"
#include "tools/calibrate/sensor_log.hpp"
#include "tools/common/program.hpp"

namespace {

slam::Config configFrom(const std::string& file, const std::vector<std::string>& overrides) {
  const slam::Config config =
      file.empty() ? slam::parseConfig("", "defaults", overrides) : slam::loadConfig(file, overrides);
  if (config.lidar_device.driver == slam::LidarDriver::kNone || config.base_device.driver == slam::BaseDriver::kNone) {
    throw slam::ConfigError({"slam-calibrate: lidar.driver and base.driver: \"none\"; calibration needs both"});
  }
  return config;
}

slam::RobotGeometry configuredGeometry(const slam::Config& config) {
  const slam::DifferentialBase& base = config.base_device.geometry;
  return {base.wheel_radius, base.wheel_radius, 2.0 * base.half_track, config.front_end.lidar.T_base_lidar};
}

slam::SensorLog readLog(const slam::Config& config, const std::string& file) {
  int shown = -1;
  slam::SensorLog log = slam::readSensorLog(config, file, [&](double seconds) {
    if (static_cast<int>(seconds) / 10 == shown) return;
    shown = static_cast<int>(seconds) / 10;
    slam::showProgress("matching: " + std::to_string(static_cast<int>(seconds)) + " s of the log");
  });
  slam::endProgress();
  if (log.truncated) std::cerr << "slam-calibrate: " << file << ": its last record is cut off; used all before it\n";
  if (log.skipped_bytes + log.rejected_messages > 0) {
    std::cerr << "slam-calibrate: " << file << ": skipped " << log.skipped_bytes << " damaged bytes and "
              << log.rejected_messages << " messages that do not decode\n";
  }
  return log;
}

void refuse(const std::string& file, const slam::Calibration& calibration) {
  const std::string motions = std::to_string(calibration.used) + " motions";
  if (calibration.status == slam::CalibrationStatus::kTooFew) {
    throw std::runtime_error(file + ": only " + motions +
                             " of decimetres with matched scans; drive for a minute, straight and turning both ways");
  }
  if (calibration.status == slam::CalibrationStatus::kContradicted) {
    throw std::runtime_error(file +
                             ": wheels and lidar contradict each other in too many motions; check that the "
                             "configured wheel radius and track are about right, left and right wheel and their signs, "
                             "and the lidar's direction of turning");
  }
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app("Calibrates wheel radii, track and the lidar's place from a recorded drive", "slam-calibrate");
  std::string config_file, log_file;
  std::vector<std::string> overrides;
  bool json = false;
  app.add_option("--config", config_file, "slamd configuration (TOML); without it slamd's defaults");
  app.add_option("--set", overrides, "section.key=value over the file; may be repeated")
      ->take_all()
      ->allow_extra_args(false);
  app.add_flag("--json", json, "machine-readable");
  app.add_option("LOG.lcm", log_file, "LCM event log with SLAM_SCAN and SLAM_WHEELS")->required();

  return slam::runProgram(app, argc, argv, SLAMD_VERSION, "slam-calibrate --config config/sim.toml drive.lcm", [&] {
    const slam::Config config = configFrom(config_file, overrides);
    const slam::RobotGeometry configured = configuredGeometry(config);
    const slam::SensorLog log = readLog(config, log_file);
    const slam::Calibration result = slam::calibrate(slam::selectMotions(log, configured), configured);
    refuse(log_file, result);
    const slam::CalibrationReport report{configured, result, log.angles_recorded};
    std::fputs((json ? report.json() : report.table()).c_str(), stdout);
    return slam::kDone;
  });
}
