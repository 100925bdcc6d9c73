// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include "estimation/ekf_timeline.hpp"
#include "estimation/odometry_monitor.hpp"
#include "frontend/depth_view_selector.hpp"
#include "frontend/intake/sensor_intake.hpp"
#include "frontend/keyframe_selector.hpp"
#include "frontend/match_validator.hpp"
#include "frontend/preprocessor.hpp"
#include "frontend/registration.hpp"
#include "frontend/tracking_state.hpp"

namespace slam {

/// Settings of a FrontEnd: those of each part, and those that several parts share.
struct FrontEndConfig {
  LidarModel lidar;
  IntakeConfig intake;
  PreprocessorConfig preprocessor;
  EkfConfig ekf;
  EkfTimelineConfig timeline;
  ReferenceConfig reference;
  MatchConfig match;
  RegistrationConfig registration;
  CorrelativeConfig search;
  SearchWindow search_window;  ///< around the prediction, after a failed match; grows with each further failure
  ValidatorConfig validator;
  DynamicObjectGateConfig dynamic_object_gate;
  WheelMonitorConfig wheel_monitor;
  GyroMonitorConfig gyro_monitor;
  ScanMonitorConfig scan_monitor;
  HeadingMonitorConfig heading_monitor;
  MountMonitorConfig mount_monitor;
  LidarDelayConfig lidar_delay;
  TrackingConfig tracking;
  KeyframeConfig keyframe;
  DepthViewConfig depth;
  bool localise_only = false;  ///< the map is given: scans do not extend it

  void visitSettings(auto& v) {
    v.section("ekf", "Kalman filter of wheels and IMU");
    ekf.visitSettings(v);
    timeline.visitSettings(v);
    v.section("match", "matching of scans against the local map");
    match.visitSettings(v);
    v.section("reference", "local map that scans are matched against");
    reference.visitSettings(v);
    v.section("keyframe", "choice of the scans that are kept for local map and map");
    keyframe.visitSettings(v);
    v.expert("max_failures", tracking.max_failures, "", 1, 10000,
             "One scan is kept at the filter's pose after this many scans in a row that could not be matched.");
    v.section("search", "search for a scan whose prediction leads to no match");
    search_window.visitSettings(v);
    wheel_monitor.visitSettings(v);
    validator.visitSettings(v);
    search.visitSettings(v);
    v.section("localisation", "limits of a degraded and of a lost pose");
    tracking.visitSettings(v);
  }
};

}  // namespace slam
