// SPDX-License-Identifier: BSD-3-Clause
#include "tools/calibrate/report.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "config/loader.hpp"
#include "tools/calibrate/motions.hpp"

namespace slam::report_test {
namespace {

using test::Drive;
using testing::HasSubstr;
using testing::Not;

CalibrationReport reportOf(Drive drive, double noise = 1.0) {
  return {test::kBelieved, calibrate(test::MotionMaker(1, noise).make(drive, 80), test::kBelieved)};
}

TEST(CalibrationReport, EndsWithLinesThatTheConfigurationTakes) {
  const CalibrationReport report = reportOf(Drive::kVaried);
  const std::string table = report.table();
  const Config config = parseConfig(table.substr(table.find("[base]")), "pasted");
  const RobotGeometry& g = report.result.geometry;
  EXPECT_NEAR(config.base_device.geometry.wheel_radius, 0.5 * (g.left_radius + g.right_radius), 1e-6);
  EXPECT_NEAR(config.base_device.geometry.half_track, 0.5 * g.track, 1e-6);
  EXPECT_NEAR(config.front_end.lidar.T_base_lidar.x, g.T_base_lidar.x, 1e-6);
  EXPECT_NEAR(config.front_end.lidar.T_base_lidar.y, g.T_base_lidar.y, 1e-6);
  EXPECT_NEAR(config.front_end.lidar.T_base_lidar.theta, g.T_base_lidar.theta, 1e-6);
}

TEST(CalibrationReport, ReportsHowTheWheelsDiffer) {
  EXPECT_THAT(reportOf(Drive::kVaried).table(), HasSubstr("The left wheel is larger by 1."));
  CalibrationReport report = reportOf(Drive::kVaried);
  report.result.geometry.left_radius = report.result.geometry.right_radius;
  EXPECT_THAT(report.table(), HasSubstr("equally large as far as the data show"));
}

TEST(CalibrationReport, GivesNoNumberForWhatIsNotDetermined) {
  const CalibrationReport report = reportOf(Drive::kStraight);
  const std::string table = report.table(), json = report.json();
  EXPECT_THAT(table, HasSubstr("Not determined by this log: track, lidar x, lidar y: the robot only drove straight"));
  EXPECT_THAT(table, HasSubstr("turn both ways"));
  EXPECT_THAT(table, HasSubstr("# half_track: not determined"));
  EXPECT_THAT(json, HasSubstr("\"track_m\": {\"configured\": 0.3180000, \"determined\": false}"));
  EXPECT_NO_THROW(parseConfig(table.substr(table.find("[base]")), "pasted"));

  const std::string spot = reportOf(Drive::kOnTheSpot).table();
  EXPECT_THAT(spot, HasSubstr("# wheel_radius: not determined"));
  EXPECT_THAT(spot, Not(HasSubstr("wheel is larger")));
}

TEST(CalibrationReport, ReportsWhereTheAnglesComeFromAndWhatWasRejected) {
  CalibrationReport report = reportOf(Drive::kVaried);
  EXPECT_THAT(report.table(), Not(HasSubstr("dead reckoning")));
  EXPECT_THAT(report.table(), Not(HasSubstr("disagree")));
  report.angles_recorded = false;
  report.result.rejected = report.result.used;
  EXPECT_THAT(report.table(), HasSubstr("The log has no wheel angles"));
  EXPECT_THAT(report.table(), HasSubstr("disagree by much: 80 of 160 motions rejected"));
  EXPECT_THAT(report.json(), HasSubstr("\"wheel_angles\": \"from dead reckoning\""));
}

TEST(CalibrationReport, WarnsOfNoiseBeyondTheClaims) {
  EXPECT_THAT(reportOf(Drive::kVaried, 8.0).table(), HasSubstr("The intervals may be too narrow."));
}

TEST(CalibrationReport, AsksForASecondRunWhereTheLidarSitsElsewhere) {
  CalibrationReport report = reportOf(Drive::kVaried);
  EXPECT_THAT(report.table(), HasSubstr("run again"));
  report.configured = report.result.geometry;
  EXPECT_THAT(report.table(), Not(HasSubstr("run again")));
}

TEST(CalibrationReport, HasEveryFieldInJson) {
  const std::string json = reportOf(Drive::kVaried).json();
  for (const char* key :
       {"motions", "used", "rejected", "translation_m", "rotation_rad", "wheel_angles", "left_radius_m",
        "right_radius_m", "track_m", "lidar_x_m", "lidar_y_m", "lidar_yaw_rad", "configured", "estimated", "sigma",
        "interval_95", "radius_left_over_right", "remarks", "toml"}) {
    EXPECT_THAT(json, HasSubstr(std::string("\"").append(key).append("\":")));
  }
  EXPECT_EQ(std::count(json.begin(), json.end(), '{'), std::count(json.begin(), json.end(), '}'));
}

}  // namespace
}  // namespace slam::report_test
