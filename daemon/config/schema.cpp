// SPDX-License-Identifier: BSD-3-Clause
#include "config/schema.hpp"

#include <array>
#include <numbers>

namespace slam {
namespace {

constexpr double kPi = std::numbers::pi;
constexpr Tier kRobot = Tier::kRobot, kSite = Tier::kSite;

void visitModeAndStore(Config& config, ConfigVisitor& v) {
  v.section("", "what slamd does");
  v.field(
      {"mode", "",
       "Mode slam extends the newest map or begins a new one; mode localise follows the robot in a map that stays as "
       "it is.",
       kRobot, "Set localise once the map is good and must not change any more."},
      config.mode);
  StoreConfig& store = config.store;
  v.section("store",
            "maps that outlast the daemon: keyframes, graph, grid, calibration, last pose; the service may write below "
            "/var/lib/slamd alone");
  v.field({"directory", "",
           "All maps are stored in this folder; if it is empty, the service uses /var/lib/slamd/maps, and other runs "
           "store none.",
           kSite, "Set it for a run outside of the service whose map is to be kept."},
          store.directory);
  v.field({"map", "",
           "The run begins with this map: a name in store.directory, a map_server .yaml file, or, if it is empty, the "
           "newest.",
           kSite, "Set it to choose among several maps; a .yaml file needs mode = \"localise\"."},
          store.map);
  v.field({"journal_period", "s", "New keyframes are written to the disk this often; a power cut loses what is newer."},
          store.journal_period, 0.1, 60.0);
  v.field({"checkpoint_period", "s", "The whole map is written to the disk this often."}, store.checkpoint_period, 1.0,
          86400.0);
}

void visitLidar(LidarDeviceConfig& lidar, LidarModel& model, ConfigVisitor& v) {
  v.section("lidar", "2D lidar: device, place on the robot, quality of its ranges");
  v.field(
      {"driver", "",
       "The scans come from an RPLidar that slamd reads, from another program over LCM (SLAM_SCAN), or from nowhere.",
       kRobot, "Set lcm for a lidar for which slamd has no driver."},
      lidar.driver);
  v.field({"port", "", "The RPLidar is connected to this serial port.", kRobot,
           "Set it where the udev rule for /dev/rplidar does not fit, e.g. with two lidars."},
          lidar.port);
  v.field({"baud", "bit/s", "The lidar's serial port runs at this speed.", kSite,
           "Set 115200 for an A1 or A2M8, 256000 for an A2M7, A2M12 or A3."},
          lidar.baud, 9600, 4000000);
  v.field({"scan_mode", "",
           "The lidar scans in its densest mode that slamd reads (auto), in legacy express mode or in standard mode."},
          lidar.scan_mode);
  v.field({"x", "m", "The lidar is mounted this far ahead of the base's turning centre.", kRobot,
           "Measure it on each robot, or use slam-calibrate."},
          model.T_base_lidar.x, -5.0, 5.0);
  v.field({"y", "m", "The lidar is mounted this far left of the base's turning centre.", kRobot,
           "Measure it on each robot, or use slam-calibrate."},
          model.T_base_lidar.y, -5.0, 5.0);
  v.field({"yaw", "rad", "The lidar's zero direction is turned by this angle to the left of the robot's forward.",
           kRobot, "Measure it on each robot, or use slam-calibrate."},
          model.T_base_lidar.theta, -kPi, kPi);
  v.field({"upside_down", "",
           "The lidar is mounted top down, so that its bearings grow clockwise when they are seen from above.", kRobot,
           "Set true when the lidar hangs from a plate."},
          model.upside_down);
  v.field({"range_min", "m", "Lidar returns that are nearer than this are ignored.", kSite,
           "Raise it when the lidar sees parts of the robot."},
          model.range_min, 0.0, 10.0);
  v.field({"range_max", "m", "Lidar returns that are farther than this are ignored.", kSite,
           "Set it to the range up to which the lidar's data sheet gives an accuracy."},
          model.range_max, 0.5, 200.0);
  v.field({"range_sigma", "m", "One range of the lidar has this standard deviation."}, model.range_sigma, 0.0005, 0.5);
  v.field(
      {"mask", "deg",
       "Beams at these bearings are left out: pairs of a first and a last angle, counter-clockwise from the lidar's "
       "zero direction.",
       kSite, "Set it where the lidar sees parts of the robot that slamd does not find by itself."},
      model.mask);
  v.field({"time_offset", "s", "This time is added to the stamps of the lidar's scans."}, model.time_offset, -1.0, 1.0);
}

void visitBase(BaseDeviceConfig& base, double& time_offset, ConfigVisitor& v) {
  v.section("base", "wheels and the geometry of the base");
  v.field({"driver", "",
           "The wheel angles come from a HandsFree board, from two ODrives on CAN, from another program over LCM "
           "(SLAM_WHEELS), or from nowhere.",
           kRobot, "Set it to what drives the wheels of the robot."},
          base.driver);
  v.field(
      {"type", "",
       "The base has two driven wheels (differential), three omni wheels (omni3) or four mecanum wheels (mecanum4).",
       kRobot, "Set omni3 or mecanum4 for a base that can move sideways."},
      base.type);
  v.field({"port", "", "The HandsFree board is connected to this serial port.", kRobot,
           "Set it where the udev rule for /dev/handsfree does not fit."},
          base.port);
  v.field({"baud", "bit/s", "The serial port of the HandsFree board runs at this speed."}, base.baud, 9600, 4000000);
  v.field({"wheel_radius", "m", "A driven wheel has this radius.", kRobot,
           "Measure it on each robot, or use slam-calibrate."},
          base.geometry.wheel_radius, 0.005, 1.0);
  v.field(
      {"half_track", "m",
       "This is half the distance between the driven wheels; omni3: centre to wheel; mecanum4: half track plus half "
       "wheelbase.",
       kRobot, "Measure it on each robot, or use slam-calibrate."},
      base.geometry.half_track, 0.01, 2.0);
  v.field({"mileage_rate", "Hz", "The HandsFree board is asked for its wheel angles at this rate."}, base.mileage_rate,
          1.0, 200.0);
  v.field({"imu_rate", "Hz", "The HandsFree board is asked for its IMU's values at this rate."}, base.imu_rate, 1.0,
          200.0);
  v.field(
      {"sample_age", "s",
       "The HandsFree board's values are taken to be this old when they are sent, until slamd has measured their age."},
      base.sample_age, 0.0, 0.2);
  v.field({"speed_commands", "",
           "Whoever sends SLAM_DRIVE over LCM may drive the base through slamd, if base.driver is handsfree or can.",
           kSite, "Set true when a navigation program drives the robot through slamd."},
          base.speed_commands);
  v.field({"drive_order", "",
           "Where several programs send SLAM_DRIVE, the one that began first is driven until it ends, or the one that "
           "began last."},
          base.drive_order);
  v.field({"max_speed", "m/s",
           "The base is driven at most this fast; a SLAM_DRIVE that asks for more is made slower on the same curve.",
           kSite, "Set it to the speed from which the robot stops within the room that it has."},
          base.limits.max_speed, 0.01, 10.0);
  v.field({"max_turn_rate", "rad/s",
           "The base is turned at most this fast; a SLAM_DRIVE that asks for more is made slower on the same curve.",
           kSite, "Set it to the turn rate at which the robot harms nobody beside it."},
          base.limits.max_turn_rate, 0.01, 20.0);
  v.field({"time_offset", "s", "This time is added to the stamps of the wheels' samples."}, time_offset, -1.0, 1.0);
}

void visitImu(ImuDeviceConfig& imu, double& time_offset, ConfigVisitor& v) {
  v.section("imu", "inertial unit");
  v.field({"driver", "",
           "The gyro is on the HandsFree board, on a serial port of its own (hfi), on CAN, in another program over LCM "
           "(SLAM_IMU), or missing.",
           kRobot, "Set hfi for a HandsFree A9, B6, B9 or D6; set none if the robot has no gyro."},
          imu.driver);
  v.field({"port", "", "The HandsFree IMU of imu.driver = \"hfi\" is connected to this serial port.", kSite,
           "Set it where the udev rule for /dev/hfi does not fit."},
          imu.port);
  v.field({"baud", "bit/s", "The IMU's own serial port runs at this speed: 921600, or 9600 for a D6."}, imu.baud, 9600,
          4000000);
  v.field({"roll", "rad",
           "The IMU is mounted with this rotation about the forward axis, positive with its right side down.", kSite,
           "Set it when slamd reads an IMU that is not mounted level; 3.14159 is upside down."},
          imu.roll, -kPi, kPi);
  v.field({"pitch", "rad",
           "The IMU is mounted with this rotation about the axis to the left, positive with its front down."},
          imu.pitch, -kPi, kPi);
  v.field({"yaw", "rad", "The IMU is mounted with this rotation about the vertical axis, positive to the left."},
          imu.yaw, -kPi, kPi);
  v.field({"time_offset", "s", "This time is added to the stamps of the IMU's samples."}, time_offset, -1.0, 1.0);
}

void visitCan(CanConfig& can, ConfigVisitor& v) {
  v.section("can", "bus of wheels (ODrive CANSimple) and IMU (Xsens), for base.driver or imu.driver = \"can\"");
  v.field({"interface", "",
           "Wheels and IMU are on this SocketCAN interface, whose bit rate is set by the system, not by slamd.", kSite,
           "Set it when the robot has several CAN interfaces."},
          can.interface);
  v.field({"left_node", "", "The ODrive axis of the left wheel has this CANSimple node number.", kSite,
           "Set it to the node number that is stored in the left wheel's axis; ODrives come with 0 and 1."},
          can.left_node, 0, 63);
  v.field({"right_node", "", "The ODrive axis of the right wheel has this CANSimple node number.", kSite,
           "Set it to the node number that is stored in the right wheel's axis."},
          can.right_node, 0, 63);
  v.field({"left_reversed", "", "The encoder of the left wheel counts down when the robot drives forward.", kSite,
           "Set true when the left wheel is reported to turn backwards."},
          can.left_reversed);
  v.field({"right_reversed", "", "The encoder of the right wheel counts down when the robot drives forward.", kSite,
           "Set true when the right wheel is reported to turn backwards."},
          can.right_reversed);
  v.field({"gear_ratio", "1", "The encoder makes this many turns for one turn of the wheel.", kSite,
           "Set it when there is a gear between motor and wheel."},
          can.gear_ratio, 0.001, 1000.0);
  v.field(
      {"watchdog_endpoint", "",
       "ODrives of firmware 0.6 tell slamctl doctor under this number whether axis0.config.enable_watchdog is on; 0: "
       "they are not asked."},
      can.watchdog_endpoint, 0, 65535);
}

void visitDepth(DepthDeviceConfig& depth, DepthViewConfig& view, ConfigVisitor& v) {
  DepthProjectionConfig& projection = depth.projection;
  DepthExtrinsics& at = projection.extrinsics;
  v.section("depth", "depth camera: device, place on the robot, use of its images");
  v.field(
      {"driver", "",
       "The depth images come from a camera that slamd reads through OpenNI2, over LCM (SLAM_DEPTH), or from nowhere.",
       kRobot, "Set none if the robot has no depth camera."},
      depth.driver);
  v.field({"uri", "",
           "This is the OpenNI2 address of the camera, or an .oni recording to play; the first camera is used if it is "
           "empty."},
          depth.uri);
  v.field({"width", "pixel", "The depth images have this width: 640 at 30 Hz, 320 at 30 or 60 Hz, or 160."},
          depth.width, 160, 1280);
  v.field({"height", "pixel", "The depth images have this height: 480, 240 or 120, as depth.width requires."},
          depth.height, 120, 1024);
  v.field({"rate", "Hz", "The camera takes depth images at this rate."}, depth.rate, 1, 120);
  v.field(
      {"record", "",
       "The depth images are recorded into this .oni file, with -2 behind its name if it exists; nothing is recorded "
       "if it is empty."},
      depth.record);
  v.field({"x", "m", "The camera is mounted this far ahead of the base's turning centre.", kRobot,
           "Measure it on each robot."},
          at.x, -5.0, 5.0);
  v.field({"y", "m", "The camera is mounted this far left of the base's turning centre.", kSite,
           "Set it when the camera is not in the middle of the robot."},
          at.y, -5.0, 5.0);
  v.field({"z", "m", "The camera is mounted this far above the floor; its images are not used while this is 0.", kRobot,
           "Measure it on each robot that has a depth camera."},
          at.z, 0.0, 3.0);
  v.field(
      {"roll", "rad", "The camera is rotated by this angle about its optical axis, positive with its right side down."},
      at.roll, -kPi, kPi);
  v.field({"pitch", "rad", "The camera looks down from the horizontal by this angle.", kRobot,
           "Measure it on each robot; SLAM_HEALTH names the error that the floor shows."},
          at.pitch, -1.2, 1.2);
  v.field({"yaw", "rad", "The camera looks to the left of the robot's forward by this angle."}, at.yaw, -kPi, kPi);
  v.field({"time_offset", "s", "This time is added to the stamps of the depth images."}, view.time_offset, -1.0, 1.0);
  v.field({"floor_clearance", "m", "The robot drives over things that are lower than this.", kSite,
           "Set it to the height of the step that the wheels can take."},
          projection.floor_clearance, 0.01, 0.5);
  v.field({"robot_height", "m", "The robot drives under things that begin above this height.", kSite,
           "Set it to the height of the robot with its load."},
          projection.robot_height, 0.05, 3.0);
  v.field({"range_min", "m", "Depth values that are nearer than this are ignored."}, projection.range_min, 0.1, 5.0);
  v.field({"range_max", "m",
           "The camera draws obstacles up to this distance; its depth has steps of 5 cm at 4 m, and the lidar sees "
           "farther."},
          projection.range_max, 0.5, 10.0);
  v.field(
      {"median", "",
       "Each pixel is the median of this many images: 1 for none, or 3 for less noise on a robot that moves slowly."},
      projection.median, 1, 3);
  v.field({"max_tilt", "rad",
           "The camera's tilt follows the floor up to this angle from its mounting, as far as bracket and suspension "
           "give."},
          projection.floor.max_tilt, 0.0, 0.3);
}

void visitMap(OccupancyGridConfig& map, OutputConfig& output, ConfigVisitor& v) {
  v.section("map", "occupancy grid");
  v.field({"resolution", "m", "One cell of the map has this side length.", kSite,
           "Lower it for narrow places, raise it to save memory in large halls."},
          map.resolution, 0.005, 1.0);
  v.field({"max_range", "m", "Lidar returns that are farther than this are not drawn into the map."}, map.max_range,
          0.5, 200.0);
  v.field({"fusion", "",
           "The lidar and the depth camera draw into layers of their own that later scans can clear (layers), or as in "
           "the paper (paper)."},
          map.fusion);
  v.field({"hit_probability", "1", "A cell in which a lidar beam ended once is occupied with this probability."},
          map.lidar.hit_probability, 0.51, 0.99);
  v.field({"miss_probability", "1", "A cell that a lidar beam crossed once is occupied with this probability."},
          map.lidar.miss_probability, 0.01, 0.49);
  v.field({"min_probability", "1", "The lidar never makes the probability that a cell is occupied lower than this."},
          map.lidar.min_probability, 0.001, 0.19);
  v.field({"max_probability", "1", "The lidar never makes the probability that a cell is occupied higher than this."},
          map.lidar.max_probability, 0.66, 0.999);
  v.field({"depth_hit_probability", "1",
           "A cell in which the depth camera saw an obstacle once is occupied with this probability."},
          map.depth.hit_probability, 0.51, 0.99);
  v.field({"depth_miss_probability", "1",
           "A cell through which the depth camera looked once at all heights is occupied with this probability."},
          map.depth.miss_probability, 0.01, 0.49);
  v.field({"depth_min_probability", "1",
           "The depth camera never makes the probability that a cell is occupied lower than this."},
          map.depth.min_probability, 0.001, 0.19);
  v.field({"depth_max_probability", "1",
           "The depth camera never makes the probability that a cell is occupied higher than this."},
          map.depth.max_probability, 0.66, 0.999);

  v.section(
      "output",
      "files that are written; ~ and variables are not expanded; the service may write below /var/lib/slamd alone");
  v.field({"map", "",
           "The map is written to this path with .yaml, .pgm and .png added, at the end of the run; no files if it is "
           "empty."},
          output.map);
  v.field(
      {"record", "",
       "All published messages are appended to this LCM event log, even without a network; there is no log if it is "
       "empty."},
      output.record);
}

void visitLog(LogConfig& log, ConfigVisitor& v) {
  v.section("log", "field log: a folder for each run, in files that slam-replay reads; see slamctl log");
  v.field(
      {"directory", "",
       "The field logs are written into this folder; if it is empty, the service uses /var/lib/slamd/log, and other "
       "runs write none."},
      log.directory);
  v.field({"automatic", "", "The field log begins when slamd starts; if false, slamctl log start begins it.", kSite,
           "Set false when only chosen drives are to be logged."},
          log.automatic);
  v.field({"quota", "MB",
           "All field logs together take no more than this; the oldest files are deleted first, marked ones last.",
           kSite, "Set it to the part of the disk that logs may fill."},
          log.quota, 1.0, 1e6);
  v.field({"floor", "MB", "The field log stops while less than this is free on its disk, so that the maps have room."},
          log.floor, 0.0, 1e6);
  v.field({"file_length", "s", "A new file of the field log begins after this time."}, log.file_length, 1.0, 86400.0);
  v.field(
      {"content", "", "The field log holds the sensors' messages that a replay needs (raw), or every message (all)."},
      log.content);
  v.field({"images", "", "The depth camera's images are recorded into the folder of the field log, as an .oni file."},
          log.images);
}

void visitDaemon(LcmConfig& lcm, RuntimeConfig& runtime, ConfigVisitor& v) {
  v.section("lcm", "messages over LCM");
  v.field(
      {"url", "",
       "LCM messages are sent to this UDP multicast group; ttl=0 keeps them on this computer, ttl=1 within the local "
       "network.",
       kSite, "Set ttl=1 when other computers are to receive the pose or the map."},
      lcm.url);
  v.field({"pose_rate", "Hz", "POSE, SLAM_POSE and SLAM_ODOMETRY are sent at this rate."}, lcm.pose_rate, 1.0, 200.0);
  v.field({"map_refresh", "s", "Every tile of the map is sent once in this time, whether it changed or not."},
          lcm.map_refresh, 0.5, 3600.0);
  v.field({"commands", "", "Whoever sends SLAM_COMMAND over LCM may save, load and reset the map and set the pose.",
           kSite, "Set true when a program on another computer commands slamd; slamctl uses the local socket."},
          lcm.commands);

  v.section("runtime", "threads, and the socket for commands");
  v.field({"estimator_rate", "Hz", "The estimator thread runs at this rate."}, runtime.estimator_rate, 20.0, 1000.0);
  v.field({"base_rate", "Hz", "The thread that reads wheels and IMU runs at this rate."}, runtime.base_rate, 20.0,
          1000.0);
  v.field({"realtime", "",
           "Threads run under SCHED_FIFO with locked memory where that is permitted, and slamd warns where it is not."},
          runtime.realtime);
  v.field({"socket", "",
           "The programs slamctl and slam-web use the socket of this path, open to group slamd; if it is empty, the "
           "service "
           "uses /run/slamd/socket."},
          runtime.socket);
  v.field({"base_priority", "", "The thread that reads wheels and IMU has this SCHED_FIFO priority."},
          runtime.base_priority, 1, 99);
  v.field({"lidar_priority", "", "The thread that reads the lidar has this SCHED_FIFO priority."},
          runtime.lidar_priority, 1, 99);
  v.field({"depth_priority", "", "The thread that reads the depth camera has this SCHED_FIFO priority."},
          runtime.depth_priority, 1, 99);
  v.field({"estimator_priority", "", "The estimator thread has this SCHED_FIFO priority."}, runtime.estimator_priority,
          1, 99);
}

void visitWeb(WebConfig& web, ConfigVisitor& v) {
  v.section("web", "slam-web, the page with the live map; a program of its own");
  v.field(
      {"address", "", "slam-web listens on this address: 127.0.0.1 for this computer alone, 0.0.0.0 for all networks.",
       kSite, "Set 0.0.0.0 when the page is to be opened from other computers; anybody there may look."},
      web.address);
  v.field({"port", "", "slam-web listens on this TCP port."}, web.port, 1, 65535);
  v.field({"commands", "", "The page can save the map, set the pose and mark the log, for those who know web.token.",
           kSite, "Set true, together with web.token, when the robot is operated from the page."},
          web.commands);
  v.field({"token", "",
           "This is the password for commands from the page; it has 12 characters or more and is never printed.", kSite,
           "Set it when web.commands is true, e.g. to what openssl rand -hex 16 prints.", /*secret=*/true},
          web.token);
}

void visitEkf(EkfConfig& ekf, EkfTimelineConfig& timeline, ConfigVisitor& v) {
  v.section("ekf", "Kalman filter of wheels and IMU");
  v.field({"acceleration_noise", "m/s per sqrt(s)", "The speed changes as a random walk with this standard deviation."},
          ekf.acceleration_noise, 0.01, 100.0);
  v.field({"angular_acceleration_noise", "rad/s per sqrt(s)",
           "The turn rate changes as a random walk with this standard deviation."},
          ekf.angular_acceleration_noise, 0.01, 100.0);
  v.field({"gyro_bias_noise", "rad/s per sqrt(s)",
           "The gyro's bias changes as a random walk with this standard deviation."},
          ekf.gyro_bias_noise, 0.0, 0.1);
  v.field({"initial_gyro_bias_sigma", "rad/s", "The gyro's bias has this standard deviation at the start."},
          ekf.initial_gyro_bias_sigma, 1e-5, 1.0);
  v.field({"translation_noise", "m per sqrt(m)",
           "The distance that the wheels measure has this standard deviation after one metre."},
          ekf.translation_noise, 0.0, 1.0);
  v.field({"rotation_noise_per_metre", "rad per sqrt(m)",
           "The heading that the wheels measure without a gyro has this standard deviation after one metre."},
          ekf.rotation_noise_per_metre, 0.0, 1.0);
  v.field(
      {"rotation_noise_wheels", "rad per sqrt(rad)",
       "The heading that the wheels measure without a gyro has this standard deviation after a turn of one radian."},
      ekf.rotation_noise_wheels, 0.0, 1.0);
  v.field({"rotation_noise_gyro", "rad per sqrt(rad)",
           "The heading that the gyro measures has this standard deviation after a turn of one radian."},
          ekf.rotation_noise_gyro, 0.0, 1.0);
  v.field(
      {"rotation_drift", "rad per sqrt(s)", "The heading gains this standard deviation in one second, even at rest."},
      ekf.rotation_drift, 1e-6, 0.1);
  v.field(
      {"translation_drift", "m per sqrt(s)", "The position gains this standard deviation in one second, even at rest."},
      ekf.translation_drift, 1e-6, 0.1);
  v.field({"wheel_speed_sigma", "m/s", "The speed in one wheel sample has this standard deviation."},
          ekf.wheel_speed_sigma, 1e-4, 1.0);
  v.field({"wheel_turn_rate_sigma", "rad/s",
           "The turn rate in one wheel sample has this standard deviation; it is used without a gyro only."},
          ekf.wheel_turn_rate_sigma, 1e-4, 5.0);
  v.field({"wheel_turn_rate_scale", "1", "The turn rate of the wheels is wrong by this share of itself."},
          ekf.wheel_turn_rate_scale, 0.0, 1.0);
  v.field({"gyro_sigma", "rad/s", "One gyro sample has this standard deviation."}, ekf.gyro_sigma, 1e-5, 1.0);
  v.field({"gyro_timeout", "s", "The wheels give the turn rate after this time without a gyro sample."},
          ekf.gyro_timeout, 0.01, 10.0);
  v.field({"slip_angle", "rad",
           "The wheels slip when they and the gyro differ by more than this angle within ekf.slip_window."},
          ekf.slip_angle, 1e-3, 3.0);
  v.field({"slip_scale", "1",
           "Slip also requires that wheels and gyro differ by more than this share of the angle turned in "
           "ekf.slip_window."},
          ekf.slip_scale, 0.0, 1.0);
  v.field({"slip_window", "s", "Wheels and gyro are compared over this time to detect slip."}, ekf.slip_window, 0.02,
          10.0);
  v.field(
      {"slip_speed_sigma", "m/s", "The speed in one wheel sample has this standard deviation while the wheels slip."},
      ekf.slip_speed_sigma, 1e-3, 10.0);
  v.field({"gate_probability", "1", "The innovation gates accept this share of good measurements."},
          ekf.gate_probability, 0.9, 0.999999);
  v.field({"max_speed", "m/s", "A wheel sample with a higher speed than this is a fault and is not used."},
          ekf.max_speed, 0.1, 100.0);
  v.field({"max_turn_rate", "rad/s", "A wheel sample with a higher turn rate than this is a fault and is not used."},
          ekf.max_turn_rate, 0.1, 100.0);
  v.field({"nis_memory", "", "The filter's prediction is judged by this many matched scans."}, ekf.nis_memory, 1, 1000);
  v.field({"max_coast", "s", "The pose moves on for no longer than this without any sample."}, ekf.max_coast, 0.0,
          10.0);
  v.field({"standstill_speed", "m/s", "The robot can stand still only while its wheels are slower than this."},
          ekf.standstill.max_speed, 0.0, 0.1);
  v.field(
      {"standstill_turn_rate", "rad/s", "The robot can stand still only while its wheels turn it slower than this."},
      ekf.standstill.max_turn_rate, 0.0, 0.5);
  v.field({"standstill_gyro_swing", "rad/s",
           "The robot stands still only while the gyro's largest and smallest readings differ by no more than this."},
          ekf.standstill.max_gyro_swing, 0.0, 1.0);
  v.field({"standstill_time", "s", "The robot stands still once wheels and gyro have been quiet for this time."},
          ekf.standstill.min_time, 0.05, 10.0);
  v.field({"window", "s", "A sample that is late by no more than this is still fused at its own stamp."},
          timeline.window, 0.05, 10.0);
}

void visitMatching(FrontEndConfig& front_end, ConfigVisitor& v) {
  MatchConfig& match = front_end.match;
  v.section("match", "matching of scans against the local map");
  v.field({"method", "",
           "Scans are matched to lines (plicp) or, as the paper's baseline, to points (icp); searches match to lines."},
          match.method);
  v.field({"max_iterations", "", "A match that has not converged after this many iterations has failed."},
          match.max_iterations, 1, 1000);
  v.field({"min_pairs", "", "A match with fewer paired points than this has failed."}, match.min_pairs, 3, 4000);
  v.field({"initial_pair_distance", "m", "A point is paired with a line up to this distance in the first iteration."},
          match.initial_pair_distance, 0.02, 2.0);
  v.field({"final_pair_distance", "m", "A point is paired with a line up to this distance in the last iterations."},
          match.final_pair_distance, 0.02, 2.0);
  v.field({"kernel_scale", "m", "A pair with this residual has half the weight of a pair without any."},
          match.kernel_scale, 0.005, 1.0);
  v.field({"point_weight", "1", "A point that lies on no line has this share of the weight of a point on a line."},
          match.point_weight, 0.0, 1.0);
  v.field(
      {"grazing_observations", "1",
       "A wall point seen at grazing incidence becomes a landmark after this many keyframes have observed it again."},
      match.grazing_observations, 0.0, 1000.0);
  v.field({"overlap_distance", "m", "A point agrees with the local map if it is this near to its line."},
          match.overlap_distance, 0.005, 1.0);
  v.field({"min_overlap", "1", "A match in which a smaller share of the points agrees with the local map has failed."},
          match.min_overlap, 0.0, 1.0);
  v.field({"min_information", "1",
           "A direction that is observed by a smaller share of the pairs than this is not corrected."},
          match.min_information, 0.0, 0.5);

  ReferenceConfig& reference = front_end.reference;
  v.section("reference", "local map that scans are matched against");
  v.field({"max_observations", "",
           "A surfel of the local map averages this many observations; a higher number makes the local map stiffer."},
          reference.max_observations, 1, 1000000);
  v.field({"surfel_spacing", "m", "Points that are closer than this along a wall become one surfel."},
          reference.surfel_spacing, 0.01, 1.0);
  v.field({"merge_distance", "m", "Points that are closer than this across a wall become one surfel."},
          reference.merge_distance, 0.01, 1.0);
}

void visitFrontEnd(FrontEndConfig& front_end, ConfigVisitor& v) {
  visitMatching(front_end, v);
  KeyframeConfig& keyframe = front_end.keyframe;
  v.section("keyframe", "choice of the scans that are kept for local map and map");
  v.field({"translation", "m", "A scan becomes a keyframe when the robot is this far from the last keyframe."},
          keyframe.translation, 0.01, 10.0);
  v.field({"rotation", "rad", "A scan becomes a keyframe when the robot has turned this far since the last keyframe."},
          keyframe.rotation, 0.01, kPi);
  v.field({"overlap", "1", "A scan becomes a keyframe at once when a smaller share of its points meets the local map."},
          keyframe.overlap, 0.0, 1.0);
  v.field({"known_ratio", "1", "A scan with this share of points on well-known surfels adds no keyframe to the map."},
          keyframe.known_ratio, 0.0, 1.0);
  v.field({"refresh_period", "s",
           "A robot that stands still in a known place draws a scan into the occupancy grid this often."},
          keyframe.refresh_period, 0.1, 3600.0);
  v.field({"max_failures", "",
           "One scan is kept at the filter's pose after this many scans in a row that could not be matched."},
          keyframe.max_failures, 1, 10000);

  v.section("search", "search for a scan whose prediction leads to no match");
  v.field(
      {"translation", "m",
       "The search begins with a window of this half width around the prediction and grows with each further failure."},
      front_end.search_window.translation, 0.0, 20.0);
  v.field(
      {"rotation", "rad",
       "The search begins with a window of this half angle around the prediction and grows with each further failure."},
      front_end.search_window.rotation, 0.0, kPi);
  v.field({"wheel_contradiction", "1",
           "The wheels are ignored when their mean normalised squared error against the scans is above this."},
          front_end.wheel_monitor.contradiction, 1.0, 1000.0);
  v.field({"wheel_agreement", "1",
           "Ignored wheels are used again when their mean normalised squared error against the scans is below this."},
          front_end.wheel_monitor.agreement, 0.5, 1000.0);
  v.field({"trusted_overlap", "1",
           "A found match overrules the filter if this share of its points agrees with the local map."},
          front_end.search.trusted_overlap, 0.0, 1.0);
  v.field({"ambiguity", "1",
           "A search has no result when its second-best place has more than this share of the best one's score."},
          front_end.search.ambiguity, 0.0, 1.0);

  v.section("localisation", "limits of a degraded and of a lost pose");
  v.field({"degraded_after", "s", "The pose is degraded after this time without a matched scan."},
          front_end.degraded_after, 0.1, 60.0);
  v.field({"lost_position_sigma", "m", "A position with a larger standard deviation than this is not valid."},
          front_end.lost_position_sigma, 0.05, 100.0);
}

void visitBackEnd(BackEndConfig& back_end, DriftConfig& drift, ConfigVisitor& v) {
  LoopClosureConfig& closure = back_end.closure;
  v.section("loop_closure", "correction of the map where the robot comes back to an old part of it");
  v.field({"enabled", "", "The map is corrected by loop closures; if false, it never is."}, back_end.close_loops);
  v.field({"max_search", "m", "Loop closures are searched up to this distance from the expected place."},
          closure.max_search, 0.3, 50.0);
  v.field(
      {"min_overlap", "1", "A loop closure needs at least this share of the newest points to agree with the old map."},
      closure.min_overlap, 0.1, 1.0);
  v.field(
      {"sure_overlap", "1",
       "A loop closure in a narrow window needs no second one if this share of its points agrees with the old map."},
      closure.sure_overlap, 0.1, 1.0);
  v.field({"consistency", "m",
           "Two loop closures confirm each other if they differ by less than this over the path between them."},
          closure.consistency, 0.01, 5.0);
  v.field(
      {"max_chi_square", "1", "A loop closure is removed when its chi-square error in the pose graph is above this."},
      closure.max_chi_square, 1.0, 10000.0);
  v.field(
      {"active_sigma", "m",
       "Scans are matched against keyframes whose position relative to the robot has a standard deviation below this."},
      closure.active_sigma, 0.005, 5.0);
  v.field({"drift_translation", "m per sqrt(m)",
           "The position from matched scans has this standard deviation after one metre."},
          drift.translation, 1e-4, 1.0);
  v.field({"drift_rotation_per_metre", "rad per sqrt(m)",
           "The heading from matched scans has this standard deviation after one metre."},
          drift.rotation_per_metre, 1e-5, 1.0);
  v.field({"drift_rotation_per_radian", "rad per sqrt(rad)",
           "The heading from matched scans has this standard deviation after a turn of one radian."},
          drift.rotation_per_radian, 1e-5, 1.0);

  RelocalisationConfig& found = back_end.relocalisation;
  v.section("relocalisation", "search for a lost robot in the whole map");
  v.field({"min_overlap", "1",
           "A place in the map, found or given by a person, is accepted if this share of the points agrees with it."},
          found.min_overlap, 0.1, 1.0);
  v.field({"searches", "1", "A place is judged by the mean log-likelihood of this many newest searches at most."},
          found.places.searches, 1, 100);
  v.field(
      {"min_margin", "1",
       "The best place must exceed any other by this mean log-likelihood; fewer searches need more, floor plans three "
       "quarters."},
      found.places.min_margin, 1.0, 1000.0);
}

constexpr std::array kRetired = std::to_array<RetiredKey>({
    {"search", "max_doubt", "the match starts from several poses where its overlap drops, or the wheels are ignored"},
    {"search", "wheel_guidance",
     "the match starts from several poses where its overlap drops, or the wheels are ignored"},
    {"localisation", "kidnap_distance", "a robot is carried away when its scans see through the walls around it"},
    {"relocalisation", "min_seen", "that the robot is in no place of the map is one of the places compared"},
});

constexpr std::array kRenamed = std::to_array<RenamedKey>({
    {"ekf", "doubt_memory", "nis_memory"},
    {"match", "sliding_observations", "grazing_observations"},
    {"keyframe", "familiarity", "known_ratio"},
    {"keyframe", "look_period", "refresh_period"},
    {"relocalisation", "min_lead", "min_margin"},
});

}  // namespace

std::span<const RetiredKey> retiredKeys() { return kRetired; }
std::span<const RenamedKey> renamedKeys() { return kRenamed; }

void visitConfig(Config& config, ConfigVisitor& visitor) {
  visitModeAndStore(config, visitor);
  visitLidar(config.lidar_device, config.front_end.lidar, visitor);
  visitBase(config.base_device, config.front_end.wheel_time_offset, visitor);
  visitImu(config.imu_device, config.front_end.imu_time_offset, visitor);
  visitCan(config.can, visitor);
  visitDepth(config.depth_device, config.front_end.depth, visitor);
  visitMap(config.map, config.output, visitor);
  visitLog(config.log, visitor);
  visitDaemon(config.lcm, config.runtime, visitor);
  visitWeb(config.web, visitor);
  visitEkf(config.front_end.ekf, config.front_end.timeline, visitor);
  visitFrontEnd(config.front_end, visitor);
  visitBackEnd(config.back_end, config.front_end.drift, visitor);
}

}  // namespace slam
