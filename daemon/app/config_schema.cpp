// SPDX-License-Identifier: BSD-3-Clause
#include "app/config_schema.hpp"

#include <numbers>

namespace slam {
namespace {

constexpr double kPi = std::numbers::pi;
const std::vector<std::string> kAnyText;
constexpr bool kBasic = true;

void visitModeAndStore(Config& config, ConfigVisitor& v) {
  v.section("", "what slamd does");
  v.field({"mode", "", "slam: extend the newest map, or begin one; localise: find and follow the robot in a given map",
           kBasic},
          config.mode, {"slam", "localise"});
  StoreConfig& store = config.store;
  v.section("store",
            "maps that outlast the daemon: keyframes, graph, grid, calibration, last pose; the service may write below "
            "/var/lib/slamd alone");
  v.field(
      {"directory", "", "folder of the maps; empty: as a service /var/lib/slamd/maps, else a map ends with the daemon"},
      store.directory, kAnyText);
  v.field(
      {"map", "", "map to begin with: a name in the folder, or a map_server .yaml to localise in; empty: the newest"},
      store.map, kAnyText);
  v.field({"journal_period", "s", "what is newer may be lost when the power is cut"}, store.journal_period, 0.1, 60.0);
  v.field({"checkpoint_period", "s", "between two whole writings of the map"}, store.checkpoint_period, 1.0, 86400.0);
}

void visitDevices(Config& config, ConfigVisitor& v) {
  LidarDeviceConfig& lidar = config.lidar_device;
  LidarModel& model = config.localizer.lidar;
  v.section("lidar", "2D lidar (RPLidar A1/A2), its place on the robot and what its ranges are worth");
  v.field({"driver", "", "who reads the lidar: slamd, somebody who sends SLAM_SCAN over LCM, or nobody", kBasic},
          lidar.driver, {"rplidar", "lcm", "none"});
  v.field({"port", "", "serial port or pseudo-terminal", kBasic}, lidar.port, kAnyText);
  v.field({"baud", "bit/s", "115200 for A1 and A2M8, 256000 for A2M7, A2M12 and A3"}, lidar.baud, 9600, 4000000);
  v.field({"scan_mode", "", "auto takes the densest mode that the unit offers and slamd reads"}, lidar.scan_mode,
          {"auto", "express", "standard"});
  v.field({"x", "m", "T_base_lidar: lidar ahead of the base's turning centre", kBasic}, model.T_base_lidar.x, -5.0,
          5.0);
  v.field({"y", "m", "T_base_lidar: lidar left of the base's turning centre", kBasic}, model.T_base_lidar.y, -5.0, 5.0);
  v.field({"yaw", "rad", "T_base_lidar: direction of the lidar's zero, counter-clockwise from forward", kBasic},
          model.T_base_lidar.theta, -kPi, kPi);
  v.field({"upside_down", "", "the lidar hangs top down: its bearings grow clockwise, seen from above"},
          model.upside_down);
  v.field({"range_min", "m", "shorter returns are not obstacles (e.g. the robot itself)"}, model.range_min, 0.0, 10.0);
  v.field({"range_max", "m", "longer returns are not trusted"}, model.range_max, 0.5, 200.0);
  v.field({"range_sigma", "m", "standard deviation of one range"}, model.range_sigma, 0.0005, 0.5);
  v.field({"time_offset", "s", "added to the lidar's stamps"}, model.time_offset, -1.0, 1.0);

  BaseDeviceConfig& base = config.base_device;
  v.section("base", "wheels and the geometry of the base");
  v.field({"driver", "",
           "who reads the wheels: slamd from a HandsFree board or from CAN, somebody who sends SLAM_WHEELS over LCM, "
           "nobody",
           kBasic},
          base.driver, {"handsfree", "can", "lcm", "none"});
  v.field({"type", "", "differential; omni3 and mecanum4 move sideways, too"}, base.type,
          {"differential", "omni3", "mecanum4"});
  v.field({"port", "", "serial port or pseudo-terminal of the board", kBasic}, base.port, kAnyText);
  v.field({"baud", "bit/s", "of the board's port"}, base.baud, 9600, 4000000);
  v.field({"wheel_radius", "m", "radius of a driven wheel", kBasic}, base.geometry.wheel_radius, 0.005, 1.0);
  v.field(
      {"half_track", "m",
       "half the distance between the driven wheels; omni3: centre to wheel; mecanum4: half track plus half wheelbase",
       kBasic},
      base.geometry.half_track, 0.01, 2.0);
  v.field({"mileage_rate", "Hz", "polls of the wheel angles"}, base.mileage_rate, 1.0, 200.0);
  v.field({"imu_rate", "Hz", "polls of the board's IMU"}, base.imu_rate, 1.0, 200.0);
  v.field(
      {"sample_age", "s", "age of a value when the board sends it, until slamd has found out when the board renews it"},
      base.sample_age, 0.0, 0.2);

  v.field({"speed_commands", "", "drive as SLAM_DRIVE says, from anybody on the network; with driver handsfree or can"},
          base.speed_commands);
  v.field({"time_offset", "s", "added to the wheels' stamps"}, config.localizer.wheel_time_offset, -1.0, 1.0);

  ImuDeviceConfig& imu = config.imu_device;
  v.section("imu", "inertial unit");
  v.field({"driver", "",
           "who reads the IMU: slamd from the base's HandsFree board, from a HandsFree IMU of its own (hfi: A9, B6, "
           "B9, D6) or "
           "from CAN, somebody who sends SLAM_IMU over LCM, nobody",
           kBasic},
          imu.driver, {"handsfree", "hfi", "can", "lcm", "none"});
  v.field({"port", "", "serial port of an IMU of its own"}, imu.port, kAnyText);
  v.field({"baud", "bit/s", "of that port: 921600, D6 9600"}, imu.baud, 9600, 4000000);
  v.field({"roll", "rad",
           "IMU turned about the base's x axis, right side down; of an IMU that slamd reads, as pitch and yaw"},
          imu.roll, -kPi, kPi);
  v.field({"pitch", "rad", "IMU turned about the base's y axis, front down"}, imu.pitch, -kPi, kPi);
  v.field({"yaw", "rad", "IMU turned about the base's z axis, to the left"}, imu.yaw, -kPi, kPi);
  v.field({"time_offset", "s", "added to the IMU's stamps"}, config.localizer.imu_time_offset, -1.0, 1.0);

  CanConfig& can = config.can;
  v.section("can", "bus of wheels (ODrive CANSimple) and IMU (Xsens frames), for base.driver or imu.driver = \"can\"");
  v.field({"interface", "", "SocketCAN interface; slamd does not set its bit rate nor bring it up"}, can.interface,
          kAnyText);
  v.field({"left_node", "", "CANSimple node of the left wheel"}, can.left_node, 1, 63);
  v.field({"right_node", "", "CANSimple node of the right wheel"}, can.right_node, 1, 63);
  v.field({"left_reversed", "", "the left encoder counts down when the robot drives forward"}, can.left_reversed);
  v.field({"right_reversed", "", "the right encoder counts down when the robot drives forward"}, can.right_reversed);
  v.field({"gear_ratio", "1", "turns of the encoder per turn of the wheel"}, can.gear_ratio, 0.001, 1000.0);
}

void visitDepth(DepthDeviceConfig& depth, DepthViewConfig& view, ConfigVisitor& v) {
  DepthProjectionConfig& projection = depth.projection;
  DepthExtrinsics& at = projection.extrinsics;
  v.section("depth",
            "depth camera (Asus Xtion Pro Live, OpenNI2), its place on the robot and what becomes of its images");
  v.field({"driver", "", "who reads the camera: slamd through OpenNI2, SLAM_DEPTH over LCM, or nobody", kBasic},
          depth.driver, {"openni2", "lcm", "none"});
  v.field({"uri", "", "of the camera in OpenNI2, or a recording (.oni) that is played; empty: the first camera"},
          depth.uri, kAnyText);
  v.field({"width", "pixel", "of the images: 640 (30 Hz), 320 (30 or 60 Hz), 160"}, depth.width, 160, 1280);
  v.field({"height", "pixel", "of the images: 480, 240, 120"}, depth.height, 120, 1024);
  v.field({"rate", "Hz", "of the images"}, depth.rate, 1, 120);
  v.field({"record", "",
           "file (.oni) that the images are recorded to, of the service below /var/lib/slamd; where it is there, -2 is "
           "put behind its name; empty: none"},
          depth.record, kAnyText);
  v.field({"x", "m", "camera ahead of the base's turning centre", kBasic}, at.x, -5.0, 5.0);
  v.field({"y", "m", "camera left of the base's turning centre"}, at.y, -5.0, 5.0);
  v.field({"z", "m", "camera above the floor; 0: not measured yet, its images are not used", kBasic}, at.z, 0.0, 3.0);
  v.field({"roll", "rad", "camera turned about its axis, right side down"}, at.roll, -kPi, kPi);
  v.field({"pitch", "rad", "camera looking down", kBasic}, at.pitch, -1.2, 1.2);
  v.field({"yaw", "rad", "camera turned to the left"}, at.yaw, -kPi, kPi);
  v.field({"time_offset", "s", "added to the camera's stamps"}, view.time_offset, -1.0, 1.0);
  v.field({"floor_clearance", "m", "what is lower is driven over"}, projection.floor_clearance, 0.01, 0.5);
  v.field({"robot_height", "m", "what begins higher is driven under"}, projection.robot_height, 0.05, 3.0);
  v.field({"range_min", "m", "nearer depth is not trusted"}, projection.range_min, 0.1, 5.0);
  v.field({"range_max", "m", "obstacles beyond are left to the lidar; the depth's steps are 5 cm at 4 m"},
          projection.range_max, 0.5, 10.0);
  v.field({"median", "", "images whose pixel-wise median is used: 1 (none) or 3, for a robot that moves slowly"},
          projection.median, 1, 3);
  v.field({"max_tilt", "rad", "bracket and suspension give no more; the floor is followed up to here"},
          projection.floor.max_tilt, 0.0, 0.3);
}

void visitEkf(EkfConfig& ekf, EkfTimelineConfig& timeline, ConfigVisitor& v) {
  v.section("ekf", "Kalman filter of wheels and IMU; a random walk per sqrt(s) grows with the root of time");
  v.field({"acceleration_noise", "m/s per sqrt(s)", "how fast the speed changes"}, ekf.acceleration_noise, 0.01, 100.0);
  v.field({"angular_acceleration_noise", "rad/s per sqrt(s)", "how fast the turn rate changes"},
          ekf.angular_acceleration_noise, 0.01, 100.0);
  v.field({"gyro_bias_noise", "rad/s per sqrt(s)", "wander of the gyro's bias"}, ekf.gyro_bias_noise, 0.0, 0.1);
  v.field({"initial_gyro_bias_sigma", "rad/s", "of the gyro's bias at start"}, ekf.initial_gyro_bias_sigma, 1e-5, 1.0);
  v.field({"translation_noise", "m per sqrt(m)", "of the wheels' distance"}, ekf.translation_noise, 0.0, 1.0);
  v.field({"rotation_noise_per_metre", "rad per sqrt(m)", "of the wheels' heading, without gyro"},
          ekf.rotation_noise_per_metre, 0.0, 1.0);
  v.field({"rotation_noise_wheels", "rad per sqrt(rad)", "of the wheels' heading, without gyro"},
          ekf.rotation_noise_wheels, 0.0, 1.0);
  v.field({"rotation_noise_gyro", "rad per sqrt(rad)", "scale error of the gyro"}, ekf.rotation_noise_gyro, 0.0, 1.0);
  v.field({"rotation_drift", "rad per sqrt(s)", "of the heading, always"}, ekf.rotation_drift, 1e-6, 0.1);
  v.field({"translation_drift", "m per sqrt(s)", "of the position, always"}, ekf.translation_drift, 1e-6, 0.1);
  v.field({"wheel_speed_sigma", "m/s", "of one wheel sample"}, ekf.wheel_speed_sigma, 1e-4, 1.0);
  v.field({"wheel_turn_rate_sigma", "rad/s", "of one wheel sample; used without gyro only"}, ekf.wheel_turn_rate_sigma,
          1e-4, 5.0);
  v.field({"wheel_turn_rate_scale", "1", "relative error of the wheels' turn rate"}, ekf.wheel_turn_rate_scale, 0.0,
          1.0);
  v.field({"gyro_sigma", "rad/s", "of one gyro sample"}, ekf.gyro_sigma, 1e-5, 1.0);
  v.field({"gyro_timeout", "s", "without a gyro sample the wheels give the turn rate"}, ekf.gyro_timeout, 0.01, 10.0);
  v.field({"slip_angle", "rad", "wheels and gyro differing by more within slip_window is slip"}, ekf.slip_angle, 1e-3,
          3.0);
  v.field({"slip_scale", "1", "... and by more than this share of the angle turned in it"}, ekf.slip_scale, 0.0, 1.0);
  v.field({"slip_window", "s", "memory of the slip test"}, ekf.slip_window, 0.02, 10.0);
  v.field({"slip_speed_sigma", "m/s", "of one wheel sample while slipping"}, ekf.slip_speed_sigma, 1e-3, 10.0);
  v.field({"gate_probability", "1", "share of good measurements that the innovation gates let pass"},
          ekf.gate_probability, 0.9, 0.999999);
  v.field({"max_speed", "m/s", "a faster wheel sample is a fault"}, ekf.max_speed, 0.1, 100.0);
  v.field({"max_turn_rate", "rad/s", "a faster wheel sample is a fault"}, ekf.max_turn_rate, 0.1, 100.0);
  v.field({"doubt_memory", "", "matched scans over which the prediction is judged"}, ekf.doubt_memory, 1, 1000);
  v.field({"max_coast", "s", "without any sample the pose moves on for no longer"}, ekf.max_coast, 0.0, 10.0);
  v.field({"standstill_speed", "m/s", "wheels slower than this may stand still"}, ekf.standstill.max_speed, 0.0, 0.1);
  v.field({"standstill_turn_rate", "rad/s", "wheels turning slower than this may stand still"},
          ekf.standstill.max_turn_rate, 0.0, 0.5);
  v.field({"standstill_gyro_swing", "rad/s", "largest minus smallest gyro reading at standstill"},
          ekf.standstill.max_gyro_swing, 0.0, 1.0);
  v.field({"standstill_time", "s", "quiet for so long is standstill"}, ekf.standstill.min_time, 0.05, 10.0);
  v.field({"window", "s", "a sample up to this much late is fused at its own stamp"}, timeline.window, 0.05, 10.0);
}

void visitFrontEnd(LocalizerConfig& localizer, ConfigVisitor& v) {
  MatchConfig& match = localizer.match;
  v.section("match", "point-to-line matching of scans");
  v.field({"max_iterations", "", "then the match has failed"}, match.max_iterations, 1, 1000);
  v.field({"min_pairs", "", "fewer matched points is a failure"}, match.min_pairs, 3, 4000);
  v.field({"initial_pair_distance", "m", "gate on a pair's distance in the first iteration"},
          match.initial_pair_distance, 0.02, 2.0);
  v.field({"final_pair_distance", "m", "gate on a pair's distance at the end"}, match.final_pair_distance, 0.02, 2.0);
  v.field({"kernel_scale", "m", "residual at which a pair has lost half its weight"}, match.kernel_scale, 0.005, 1.0);
  v.field({"point_weight", "1", "of a point that lies on no line against one that does"}, match.point_weight, 0.0, 1.0);
  v.field({"sliding_observations", "1", "keyframes that meet a spot on a wall seen too flat before it is a thing"},
          match.sliding_observations, 0.0, 1000.0);
  v.field({"overlap_distance", "m", "a point this near to its line agrees with the reference"}, match.overlap_distance,
          0.005, 1.0);
  v.field({"min_overlap", "1", "a smaller share of agreeing points is no match"}, match.min_overlap, 0.0, 1.0);
  v.field({"min_information", "1", "a direction seen by a smaller share of the pairs is blind"}, match.min_information,
          0.0, 0.5);

  ReferenceConfig& reference = localizer.reference;
  v.section("reference", "what scans are matched against");
  v.field({"max_observations", "", "weight of a surfel's past: more makes the reference stiffer"},
          reference.max_observations, 1, 1000000);
  v.field({"surfel_spacing", "m", "points closer than this along a wall are one"}, reference.surfel_spacing, 0.01, 1.0);
  v.field({"merge_distance", "m", "and closer than this across it"}, reference.merge_distance, 0.01, 1.0);
  KeyframeConfig& keyframe = localizer.keyframe;
  v.section("keyframe", "when a scan is kept for reference and map");
  v.field({"translation", "m", "since the last keyframe"}, keyframe.translation, 0.01, 10.0);
  v.field({"rotation", "rad", "since the last keyframe"}, keyframe.rotation, 0.01, kPi);
  v.field({"overlap", "1", "a smaller share of points that meet the reference makes a keyframe at once"},
          keyframe.overlap, 0.0, 1.0);
  v.field({"familiarity", "1", "a scan that shows this share of well-known surfels adds nothing to the map's memory"},
          keyframe.familiarity, 0.0, 1.0);
  v.field({"look_period", "s", "between refreshes of the grid from a robot that stands still in a known place"},
          keyframe.look_period, 0.1, 3600.0);
  v.field({"max_failures", "", "unmatched scans in a row, then one is kept where the filter believes to be"},
          keyframe.max_failures, 1, 10000);

  v.section("search", "where a scan is looked for when the prediction leads to no match");
  v.field({"translation", "m", "on either side of the prediction; grows with each further failure"},
          localizer.search_window.translation, 0.0, 20.0);
  v.field({"rotation", "rad", "on either side of the prediction; grows with each further failure"},
          localizer.search_window.rotation, 0.0, kPi);
  v.field({"max_doubt", "1", "scans that contradict the prediction by more make it one guess among others"},
          localizer.max_doubt, 1.0, 1000.0);
  v.field({"wheel_contradiction", "1",
           "mean normalised squared error of the wheels against the scans: above, they are not heard"},
          localizer.wheel_trust.contradiction, 1.0, 1000.0);
  v.field({"wheel_agreement", "1", "the same: below, they are heard again"}, localizer.wheel_trust.agreement, 0.5,
          1000.0);
  v.field({"wheel_guidance", "1", "the same: above, their prediction is one guess among others"},
          localizer.wheel_trust.guidance, 1.0, 1000.0);
  v.field({"trusted_overlap", "1", "a found match with this share of agreeing points overrules the filter"},
          localizer.search.trusted_overlap, 0.0, 1.0);
  v.field({"ambiguity", "1", "a second place nearly as good as the best (ratio) makes both worthless"},
          localizer.search.ambiguity, 0.0, 1.0);

  v.section("localisation", "when a pose is called degraded or lost");
  v.field({"degraded_after", "s", "without a matched scan"}, localizer.degraded_after, 0.1, 60.0);
  v.field({"kidnap_distance", "m", "no match this near to where there was one: the robot was carried away"},
          localizer.kidnap_distance, 0.0, 100.0);
  v.field({"lost_position_sigma", "m", "a position this uncertain is not valid"}, localizer.lost_position_sigma, 0.05,
          100.0);
}

void visitBackEnd(BackEndConfig& back_end, DriftConfig& drift, ConfigVisitor& v) {
  LoopClosureConfig& closure = back_end.closure;
  v.section("loop_closure", "where the robot has come back to an old part of the map");
  v.field({"enabled", "", "false: the map is never corrected"}, back_end.close_loops);
  v.field({"max_search", "m", "no drift is taken to be larger"}, closure.max_search, 0.3, 50.0);
  v.field({"min_overlap", "1", "share of the newest scans' points that must agree with the old map"},
          closure.min_overlap, 0.1, 1.0);
  v.field({"sure_overlap", "1", "so many in a narrow window, and one closure needs no second"}, closure.sure_overlap,
          0.1, 1.0);
  v.field({"consistency", "m", "two closures agree when they differ by less over the path between them"},
          closure.consistency, 0.01, 5.0);
  v.field({"max_chi_square", "1", "a closure that contradicts the rest by more is taken back"}, closure.max_chi_square,
          1.0, 10000.0);
  v.field({"active_sigma", "m", "the map is one where its parts are known this well relative to each other"},
          closure.active_sigma, 0.005, 5.0);
  v.field({"drift_translation", "m per sqrt(m)", "of matched scans, from keyframe to keyframe"}, drift.translation,
          1e-4, 1.0);
  v.field({"drift_rotation_per_metre", "rad per sqrt(m)", "of matched scans"}, drift.rotation_per_metre, 1e-5, 1.0);
  v.field({"drift_rotation_per_radian", "rad per sqrt(rad)", "of matched scans"}, drift.rotation_per_radian, 1e-5, 1.0);

  RelocalisationConfig& found = back_end.relocalisation;
  v.section("relocalisation", "how a lost robot is found in the whole map");
  v.field({"min_overlap", "1",
           "share of the points that must agree with the map where they were found, or a person placed them"},
          found.min_overlap, 0.1, 1.0);
  v.field(
      {"min_seen", "1", "share of the walls seen that must be at their places in the map; in a picture 0.55 at least"},
      found.places.min_seen, 0.1, 1.0);
  v.field({"searches", "1", "newest ones whose log-likelihoods are averaged, at most"}, found.places.searches, 1, 100);
  v.field({"min_lead", "1",
           "of the best place's log-likelihood over any other's, in the mean of many searches; 1 + 1/n times it in n; "
           "three quarters of it in a picture"},
          found.places.min_lead, 1.0, 1000.0);
}

void visitMap(OccupancyGridConfig& map, OutputConfig& output, ConfigVisitor& v) {
  v.section("map", "occupancy grid");
  v.field({"resolution", "m", "side of a cell"}, map.resolution, 0.005, 1.0);
  v.field({"max_range", "m", "longer returns are not drawn"}, map.max_range, 0.5, 200.0);
  std::string fusion = map.fusion == Fusion::kPaper ? "paper" : "layers";
  v.field({"fusion", "", "of lidar and depth; layers: later looks can take back what earlier ones said; paper: never"},
          fusion, {"layers", "paper"});
  map.fusion = fusion == "paper" ? Fusion::kPaper : Fusion::kLayers;
  v.field({"hit_probability", "1", "P(occupied) after a beam ended in a cell"}, map.lidar.hit_probability, 0.51, 0.99);
  v.field({"miss_probability", "1", "P(occupied) after a beam crossed a cell"}, map.lidar.miss_probability, 0.01, 0.49);
  v.field({"min_probability", "1", "a cell never gets surer of being free"}, map.lidar.min_probability, 0.001, 0.19);
  v.field({"max_probability", "1", "a cell never gets surer of being occupied"}, map.lidar.max_probability, 0.66,
          0.999);
  v.field({"depth_hit_probability", "1", "P(occupied) after the depth camera saw an obstacle in a cell"},
          map.depth.hit_probability, 0.51, 0.99);
  v.field({"depth_miss_probability", "1", "P(occupied) after the depth camera looked through a cell at all heights"},
          map.depth.miss_probability, 0.01, 0.49);
  v.field({"depth_min_probability", "1", "same limit for the depth camera's layer"}, map.depth.min_probability, 0.001,
          0.19);
  v.field({"depth_max_probability", "1", "same limit for the depth camera's layer"}, map.depth.max_probability, 0.66,
          0.999);

  v.section("output",
            "files written; ~ and variables are not expanded; the service may write below /var/lib/slamd alone");
  v.field({"map", "", "prefix of map files (.yaml, .pgm, .png) written at the end; empty: none"}, output.map, kAnyText);
  v.field({"record", "",
           "LCM event log of all that is published, also without network; goes on at each start; empty: none"},
          output.record, kAnyText);
}

void visitLog(LogConfig& log, ConfigVisitor& v) {
  v.section("log", "field log: a folder for each run, in files that slam-replay reads; see slamctl log");
  v.field({"directory", "", "folder of the logs; empty: as a service /var/lib/slamd/log, else nothing is logged"},
          log.directory, kAnyText);
  v.field({"automatic", "", "begin with slamd; false: slamctl log start begins"}, log.automatic);
  v.field({"quota", "MB", "of all logs together; the oldest files go first, marked ones last"}, log.quota, 1.0, 1e6);
  v.field({"floor", "MB", "stay free on the disk, for the maps: with less, logging stops until there is room"},
          log.floor, 0.0, 1e6);
  v.field({"file_length", "s", "then the next file begins"}, log.file_length, 1.0, 86400.0);
  v.field({"content", "", "raw: what a replay needs; all: every message that is sent, too"}, log.content,
          {"raw", "all"});
  v.field({"images", "", "record the depth camera's images (.oni) into the run's folder, too"}, log.images);
}

void visitDaemon(LcmConfig& lcm, RuntimeConfig& runtime, ConfigVisitor& v) {
  v.section("lcm", "publishing");
  v.field({"url", "", "LCM over UDP multicast; ttl=0 keeps messages on this machine"}, lcm.url, kAnyText);
  v.field({"pose_rate", "Hz", "POSE, SLAM_POSE and SLAM_ODOMETRY between scans"}, lcm.pose_rate, 1.0, 200.0);
  v.field({"map_refresh", "s", "all tiles are sent once in this time"}, lcm.map_refresh, 0.5, 3600.0);
  v.field({"commands", "", "obey SLAM_COMMAND from anybody on the network, too; the local socket needs no such key"},
          lcm.commands);

  v.section("runtime", "threads, and the socket for commands");
  v.field({"estimator_rate", "Hz", "of the estimator thread"}, runtime.estimator_rate, 20.0, 1000.0);
  v.field({"base_rate", "Hz", "of the base thread"}, runtime.base_rate, 20.0, 1000.0);
  v.field({"realtime", "", "SCHED_FIFO and locked memory where permitted; a warning where not"}, runtime.realtime);
  v.field({"socket", "",
           "path of the socket for slamctl and slam-web of this machine, open to group slamd; empty: as a service "
           "/run/slamd/socket, else none"},
          runtime.socket, kAnyText);
  v.field({"base_priority", "", "SCHED_FIFO priority"}, runtime.base_priority, 1, 99);
  v.field({"lidar_priority", "", "SCHED_FIFO priority"}, runtime.lidar_priority, 1, 99);
  v.field({"depth_priority", "", "SCHED_FIFO priority"}, runtime.depth_priority, 1, 99);
  v.field({"estimator_priority", "", "SCHED_FIFO priority"}, runtime.estimator_priority, 1, 99);
}

void visitWeb(WebConfig& web, ConfigVisitor& v) {
  v.section("web", "slam-web, the page with the live map; a program of its own");
  v.field({"address", "", "where it listens: 127.0.0.1 this computer alone; 0.0.0.0 all networks, anybody may look"},
          web.address, kAnyText);
  v.field({"port", "", "TCP port"}, web.port, 1, 65535);
  v.field({"commands", "", "the page can save, set the pose and mark the log, for those who know web.token"},
          web.commands);
  v.field({"token", "", "password for commands, 12 characters or more; never printed", !kBasic, true}, web.token,
          kAnyText);
}

}  // namespace

void visitConfig(Config& config, ConfigVisitor& visitor) {
  visitModeAndStore(config, visitor);
  visitDevices(config, visitor);
  visitDepth(config.depth_device, config.localizer.depth, visitor);
  visitMap(config.map, config.output, visitor);
  visitLog(config.log, visitor);
  visitDaemon(config.lcm, config.runtime, visitor);
  visitWeb(config.web, visitor);
  visitEkf(config.localizer.ekf, config.localizer.timeline, visitor);
  visitFrontEnd(config.localizer, visitor);
  visitBackEnd(config.back_end, config.localizer.drift, visitor);
}

}  // namespace slam
