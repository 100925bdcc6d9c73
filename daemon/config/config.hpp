// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <numbers>
#include <string>
#include <vector>

#include "config/choices.hpp"
#include "core/estimates.hpp"
#include "depth/depth_projection.hpp"
#include "estimation/wheel_odometry.hpp"
#include "firmware_if/can_odrive.hpp"
#include "frontend/front_end_config.hpp"
#include "mapping/occupancy_grid.hpp"
#include "slam/back_end_config.hpp"

namespace slam {

struct LidarDeviceConfig {
  LidarDriver driver = LidarDriver::kRplidar;
  std::string port = "/dev/rplidar";
  int baud = 0;  ///< [bit/s] 0: the model's own
  LidarScanMode scan_mode = LidarScanMode::kAuto;
  LdsModel model = LdsModel::kAuto;  ///< of kLds

  /// slamd reads it at a serial port.
  bool isRead() const { return driver != LidarDriver::kLcm && driver != LidarDriver::kNone; }
  /// Its model is found when the port is opened.
  bool isSearched() const {
    return driver == LidarDriver::kAuto || driver == LidarDriver::kYdlidar ||
           (driver == LidarDriver::kLds && model == LdsModel::kAuto);
  }

  void visitSettings(auto& v) {
    v.robot("driver", driver,
            "The scans come from a lidar of this model, from the one on the port (auto, ydlidar, lds), over LCM "
            "(SLAM_SCAN), or from nowhere.",
            "Set lcm for a lidar for which slamd has no driver.");
    v.robot("port", port,
            "The lidar is connected to this serial port, or has this address on the network: "
            "tcp://192.168.0.10:10940.",
            "Set it where the udev rule for /dev/rplidar does not fit, e.g. with two lidars.");
    v.site("baud", baud, "bit/s", 0, 4000000,
           "The lidar's serial port runs at this speed; 0: at the one of its model, 115200 for an RPLidar.",
           "Set 256000 for an A2M7, A2M12, A3 or S1, 460800 for a C1, 1000000 for an S2 or S3.");
    v.expert("model", model,
             "The lidar of lidar.driver = \"lds\" is this one; auto: the LDS-02 or XV-11 that is found on the port.");
    v.expert(
        "scan_mode", scan_mode,
        "An RPLidar scans in its densest mode that slamd reads (auto), in legacy express mode or in standard mode.");
  }
};

struct BaseDeviceConfig {
  BaseDriver driver = BaseDriver::kHandsfree;
  BaseType type = BaseType::kDifferential;
  std::string port = "/dev/handsfree";
  int baud = 0;  ///< [bit/s] 0: the model's own
  DifferentialBase geometry;
  double counts_per_turn = 0.0;  ///< [1] of a wheel; 0: the model's own
  double loop_rate = 30.0;       ///< [Hz] of an Arduino's speed control
  int address = 128;             ///< of a RoboClaw
  bool speed_commands = false;   ///< drive as SLAM_DRIVE says
  DriveOrder drive_order = DriveOrder::kFirst;
  SpeedLimits limits;          ///< whatever SLAM_DRIVE asks for
  double mileage_rate = 50.0;  ///< [Hz] polls of the wheel angles
  double imu_rate = 100.0;     ///< [Hz] polls of the IMU; readings that did not change are not used
  double sample_age = 0.010;   ///< [s] age of the board's values when it answers, until it has been found out

  /// slamd reads it at a serial port.
  bool isSerial() const {
    return driver != BaseDriver::kCan && driver != BaseDriver::kLcm && driver != BaseDriver::kNone;
  }

  /// It sends the turn rate of a gyro of its own along with its wheels.
  bool hasGyro() const {
    return driver == BaseDriver::kKobuki || driver == BaseDriver::kFrame || driver == BaseDriver::kOpencr;
  }
  /// What its encoders count in a turn is each robot's own.
  bool needsCounts() const {
    return driver == BaseDriver::kRosArduinoBridge || driver == BaseDriver::kFrame || driver == BaseDriver::kRoboclaw ||
           driver == BaseDriver::kVesc;
  }

  void visitSettings(auto& v) {
    v.robot("driver", driver,
            "The wheel angles come from a base of this make that slamd reads, from another program over LCM "
            "(SLAM_WHEELS), or from nowhere.",
            "Set it to what drives the wheels of the robot.");
    v.robot(
        "type", type,
        "The base has two driven wheels (differential), three omni wheels (omni3) or four mecanum wheels (mecanum4).",
        "Set omni3 or mecanum4 for a base that can move sideways.");
    v.robot("port", port, "The base is connected to this serial port.",
            "Set it where the udev rule for /dev/handsfree does not fit.");
    v.expert("baud", baud, "bit/s", 0, 4000000,
             "The base's serial port runs at this speed; 0: at the one of its model, 921600 for a HandsFree board.");
    geometry.visitSettings(v);
    v.expert("counts_per_turn", counts_per_turn, "1", 0.0, 1e6,
             "The encoder of a driven wheel counts this much in one turn of the wheel; 0: as of the "
             "base's model.");
    v.expert("loop_rate", loop_rate, "Hz", 1.0, 1000.0,
             "The speed control of an Arduino with ros_arduino_bridge runs at this rate: a speed is sent as counts per "
             "run.");
    v.expert("address", address, "", 128, 135, "A RoboClaw has this address, 80h to 87h as a decimal number.");
    v.expert("mileage_rate", mileage_rate, "Hz", 1.0, 200.0,
             "The HandsFree board is asked for its wheel angles at this rate.");
    v.expert("imu_rate", imu_rate, "Hz", 1.0, 200.0, "The HandsFree board is asked for its IMU's values at this rate.");
    v.expert("sample_age", sample_age, "s", 0.0, 0.2,
             "The HandsFree board's values are taken to be this old when they are sent, until slamd has measured "
             "their age.");
    v.site("speed_commands", speed_commands,
           "Whoever sends SLAM_DRIVE over LCM may drive the base through slamd, if slamd reads the base.",
           "Set true when a navigation program drives the robot through slamd.");
    v.expert("drive_order", drive_order,
             "Where several programs send SLAM_DRIVE, the one that began first is driven until it ends, or the one "
             "that began last.");
    limits.visitSettings(v);
  }
};

struct ImuDeviceConfig {
  ImuDriver driver = ImuDriver::kHandsfree;   ///< kHandsfree: the base board's IMU
  std::string port = "/dev/hfi";              ///< of an IMU of its own; name or folder of a chip of "iio"
  int baud = 0;                               ///< [bit/s] of the same; 0: its model's
  double roll = 0.0, pitch = 0.0, yaw = 0.0;  ///< [rad] of the IMU's axes in base

  /// An IMU of its own at a serial port.
  bool isSerial() const {
    return driver == ImuDriver::kHfi || driver == ImuDriver::kBno08x || driver == ImuDriver::kWitmotion ||
           driver == ImuDriver::kXsens;
  }

  void visitSettings(auto& v) {
    v.robot("driver", driver,
            "The gyro is the HandsFree board's, another base's (base), a separate unit (hfi, bno08x, witmotion, xsens, "
            "iio), "
            "on CAN, another program's (lcm), or missing.",
            "Set hfi for a HandsFree A9, B6, B9 or D6, iio for a chip that the kernel reads; none if the robot has no "
            "gyro.");
    v.site("port", port,
           "A separate IMU is connected to this serial port, or is the kernel's chip of this name or folder (iio).",
           "Set it where the udev rule for /dev/hfi does not fit, and for each other make.");
    v.expert("baud", baud, "bit/s", 0, 4000000,
             "A separate IMU's serial port runs at this speed; 0: 921600 for a HandsFree (a D6 has 9600), that of any "
             "other is found.");
    v.site("roll", roll, "rad", -std::numbers::pi, std::numbers::pi,
           "The IMU is mounted with this rotation about the forward axis, positive with its right side down.",
           "Set it when slamd reads an IMU that is not mounted level; 3.14159 is upside down.");
    v.expert("pitch", pitch, "rad", -std::numbers::pi, std::numbers::pi,
             "The IMU is mounted with this rotation about the axis to the left, positive with its front down.");
    v.expert("yaw", yaw, "rad", -std::numbers::pi, std::numbers::pi,
             "The IMU is mounted with this rotation about the vertical axis, positive to the left.");
  }
};

/// The CAN bus of wheels (ODrive CANSimple) and IMU (Xsens frames).
struct CanConfig {
  std::string interface = "can0";
  can::Protocol protocol = can::Protocol::kOdrive;
  int left_node = can::odrive::kLeftNode, right_node = can::odrive::kRightNode;
  bool left_reversed = false, right_reversed = false;  ///< the encoder counts down driving forward
  double gear_ratio = 1.0;                             ///< [1] turns of the encoder per turn of the wheel
  int pole_pairs = 0;                                  ///< of a VESC's motor; 0: not set
  int watchdog_endpoint = 0;                           ///< of axis0.config.enable_watchdog in 0.6; 0: not known

  void visitSettings(auto& v) {
    v.site("interface", interface,
           "Wheels and IMU are on this SocketCAN interface, whose bit rate is set by the system, not by slamd.",
           "Set it when the robot has several CAN interfaces.");
    v.expert("protocol", protocol, "The drives of the wheels are two ODrives (CANSimple), or two VESCs.");
    v.site("left_node", left_node, "", 0, 254,
           "The drive of the left wheel has this number: its CANSimple node (0 to 63), or the VESC's id.",
           "Set it to the number that is stored in the left wheel's drive; ODrives come with 0 and 1.");
    v.site("right_node", right_node, "", 0, 254, "The drive of the right wheel has this number.",
           "Set it to the number that is stored in the right wheel's drive.");
    v.site("left_reversed", left_reversed, "The encoder of the left wheel counts down when the robot drives forward.",
           "Set true when the left wheel is reported to turn backwards.");
    v.site("right_reversed", right_reversed,
           "The encoder of the right wheel counts down when the robot drives forward.",
           "Set true when the right wheel is reported to turn backwards.");
    v.site("gear_ratio", gear_ratio, "1", 0.001, 1000.0, "The encoder makes this many turns for one turn of the wheel.",
           "Set it when there is a gear between motor and wheel.");
    v.expert("pole_pairs", pole_pairs, "1", 0, 100,
             "The motor of a VESC has this many pairs of poles; 0: not set, and a VESC cannot be read.");
    v.expert("watchdog_endpoint", watchdog_endpoint, "", 0, 65535,
             "ODrives of firmware 0.6 tell slamctl doctor under this number whether axis0.config.enable_watchdog "
             "is on; 0: they are not asked.");
  }
};

struct DepthDeviceConfig {
  DepthDriver driver = DepthDriver::kOpenni2;
  std::string uri = "";           ///< OpenNI2's, or a recording (.oni); empty: the first camera
  int width = 640, height = 480;  ///< [pixel]
  int rate = 30;                  ///< [Hz]
  std::string record = "";        ///< .oni file; empty: none
  DepthProjectionConfig projection{.extrinsics = {.x = 0.10}, .floor = {}};

  /// Without its height above the floor no image can be used.
  bool isMounted() const { return projection.extrinsics.z > 0.0; }

  void visitSettings(auto& v) {
    v.robot(
        "driver", driver,
        "The depth images come from a camera that slamd reads through OpenNI2, over LCM (SLAM_DEPTH), or from nowhere.",
        "Set none if the robot has no depth camera.");
    v.expert("uri", uri,
             "This is the OpenNI2 address of the camera, or an .oni recording to play; the first camera is used if "
             "it is empty.");
    v.expert("width", width, "pixel", 160, 1280,
             "The depth images have this width: 640 at 30 Hz, 320 at 30 or 60 Hz, or 160.");
    v.expert("height", height, "pixel", 120, 1024,
             "The depth images have this height: 480, 240 or 120, as depth.width requires.");
    v.expert("rate", rate, "Hz", 1, 120, "The camera takes depth images at this rate.");
    v.expert("record", record,
             "The depth images are recorded into this .oni file, with -2 behind its name if it exists; nothing is "
             "recorded if it is empty.");
  }
};

struct LcmConfig {
  std::string url = "udpm://239.255.76.67:7667?ttl=0";
  double pose_rate = 100.0;  ///< [Hz] POSE, SLAM_POSE, SLAM_ODOMETRY
  double map_refresh = 5.0;  ///< [s] all tiles once
  bool commands = false;     ///< obey SLAM_COMMAND

  void visitSettings(auto& v) {
    v.site("url", url,
           "LCM messages are sent to this UDP multicast group; ttl=0 keeps them on this computer, ttl=1 within the "
           "local network.",
           "Set ttl=1 when other computers are to receive the pose or the map.");
    v.expert("pose_rate", pose_rate, "Hz", 1.0, 200.0, "POSE, SLAM_POSE and SLAM_ODOMETRY are sent at this rate.");
    v.expert("map_refresh", map_refresh, "s", 0.5, 3600.0,
             "Every tile of the map is sent once in this time, whether it changed or not.");
    v.site("commands", commands,
           "Whoever sends SLAM_COMMAND over LCM may save, load and reset the map and set the pose.",
           "Set true when a program on another computer commands slamd; slamctl uses the local socket.");
  }
};

struct RuntimeConfig {
  double estimator_rate = 200.0;  ///< [Hz]
  double base_rate = 211.0;       ///< [Hz] no multiple of the board's 50 Hz, so that requests meet all its phases
  bool realtime = true;           ///< SCHED_FIFO and mlockall where permitted
  std::string socket = "";        ///< path of the local socket for commands; empty: none
  int base_priority = 80;         ///< SCHED_FIFO
  int lidar_priority = 75;
  int depth_priority = 72;
  int estimator_priority = 70;

  void visitSettings(auto& v) {
    v.expert("estimator_rate", estimator_rate, "Hz", 20.0, 1000.0, "The estimator thread runs at this rate.");
    v.expert("base_rate", base_rate, "Hz", 20.0, 1000.0, "The thread that reads wheels and IMU runs at this rate.");
    v.expert(
        "realtime", realtime,
        "Threads run under SCHED_FIFO with locked memory where that is permitted, and slamd warns where it is not.");
    v.expert("socket", socket,
             "The programs slamctl and slam-web use the socket of this path, open to group slamd; if it is empty, "
             "the service uses /run/slamd/socket.");
    v.expert("base_priority", base_priority, "", 1, 99,
             "The thread that reads wheels and IMU has this SCHED_FIFO priority.");
    v.expert("lidar_priority", lidar_priority, "", 1, 99,
             "The thread that reads the lidar has this SCHED_FIFO priority.");
    v.expert("depth_priority", depth_priority, "", 1, 99,
             "The thread that reads the depth camera has this SCHED_FIFO priority.");
    v.expert("estimator_priority", estimator_priority, "", 1, 99, "The estimator thread has this SCHED_FIFO priority.");
  }
};

/// Maps that outlast the daemon.
struct StoreConfig {
  std::string directory = "";        ///< of all maps; empty: none are stored
  std::string map = "";              ///< to begin with; empty: the newest
  std::string floors = "";           ///< maps that a lost robot is searched in beside the present one; empty: none
  double journal_period = 1.0;       ///< [s]
  double checkpoint_period = 120.0;  ///< [s]

  void visitSettings(auto& v) {
    v.site("directory", directory,
           "All maps are stored in this folder; if it is empty, the service uses /var/lib/slamd/maps, and other "
           "runs store none.",
           "Set it for a run outside of the service whose map is to be kept.");
    v.site("map", map,
           "The run begins with this map: a name in store.directory, a map_server .yaml file, or, if it is empty, "
           "the newest.",
           "Set it to choose among several maps; a .yaml file needs mode = \"localise\".");
    v.expert(
        "floors", floors,
        "A lost robot is searched in these maps of store.directory, too, of other floors: names with blanks between, "
        "or * for all.");
    v.expert("journal_period", journal_period, "s", 0.1, 60.0,
             "New keyframes are written to the disk this often; a power cut loses what is newer.");
    v.expert("checkpoint_period", checkpoint_period, "s", 1.0, 86400.0,
             "The whole map is written to the disk this often.");
  }
};

struct OutputConfig {
  std::string map = "";     ///< prefix of the map files written at the end and on save_map; empty: none
  std::string record = "";  ///< LCM event log of all that is published; empty: none

  void visitSettings(auto& v) {
    v.expert("map", map,
             "The map is written to this path with .yaml, .pgm and .png added, at the end of the run; no files if "
             "it is empty.");
    v.expert("record", record,
             "All published messages are appended to this LCM event log, even without a network; there is no log "
             "if it is empty.");
  }
};

/// The field log.
struct LogConfig {
  std::string directory = "";  ///< of all runs; empty: none
  bool automatic = true;       ///< begin with slamd; else when a person wants it
  double quota = 2000.0;       ///< [MB] of all logs together
  double floor = 1000.0;       ///< [MB] that stay free on the disk
  double file_length = 600.0;  ///< [s]
  LogContent content = LogContent::kRaw;
  bool images = false;  ///< the camera's, too

  void visitSettings(auto& v) {
    v.expert("directory", directory,
             "The field logs are written into this folder; if it is empty, the service uses /var/lib/slamd/log, "
             "and other runs write none.");
    v.site("automatic", automatic, "The field log begins when slamd starts; if false, slamctl log start begins it.",
           "Set false when only chosen drives are to be logged.");
    v.site("quota", quota, "MB", 1.0, 1e6,
           "All field logs together take no more than this; the oldest files are deleted first, marked ones last.",
           "Set it to the part of the disk that logs may fill.");
    v.expert("floor", floor, "MB", 0.0, 1e6,
             "The field log stops while less than this is free on its disk, so that the maps have room.");
    v.expert("file_length", file_length, "s", 1.0, 86400.0, "A new file of the field log begins after this time.");
    v.expert("content", content,
             "The field log holds the sensors' messages that a replay needs (raw), or every message (all).");
    v.expert("images", images,
             "The depth camera's images are recorded into the folder of the field log, as an .oni file.");
  }
};

/// Of slam-web, a program of its own.
struct WebConfig {
  static constexpr std::size_t kShortestToken = 12;

  std::string address = "127.0.0.1";
  int port = 8080;
  WebReaders read = WebReaders::kAnybody;
  bool commands = false;
  std::string token = "";
  std::string token_file = "/etc/slamd/web.token";
  bool tls = false;
  std::string certificate = "";
  std::string key = "";

  /// Something is for those alone who have the token.
  bool needsToken() const { return commands || read == WebReaders::kToken; }

  void visitSettings(auto& v) {
    v.site("address", address,
           "slam-web listens on this address: 127.0.0.1 for this computer alone, 0.0.0.0 for all networks.",
           "Set 0.0.0.0 when the page is to be opened from other computers; anybody there may look.");
    v.expert("port", port, "", 1, 65535, "slam-web listens on this TCP port.");
    v.site("read", read, "The page can be read by anybody who reaches it, or only with the token.",
           "Set token when the map and the place of the robot are nobody else's business.");
    v.site("commands", commands,
           "The page can save, edit, load and delete maps, set the pose, mark the log and, with base.speed_commands, "
           "drive, for those who have the token.",
           "Set true when the robot is operated from the page.");
    v.secret("token", token,
             "This is the password of the page, of 12 characters or more, and is never printed; empty: the one in "
             "web.token_file.");
    v.expert("token_file", token_file,
             "The password of the page stands in this file, alone; who may read the file may operate the robot.");
    v.expert("tls", tls,
             "The page is served by https; a browser that asks by http is sent there, and slamctl web prints the "
             "certificate's fingerprint.");
    v.expert("certificate", certificate,
             "The certificate for https stands in this file, in PEM, with those that vouch for it behind it; empty: "
             "one that slam-web makes.");
    v.expert("key", key, "The key of web.certificate stands in this file, in PEM, and the user slamd-web can read it.");
  }
};

/// All of slamd's settings. slam-replay uses the parts that are not about devices.
struct Config {
  RunMode mode = RunMode::kSlam;
  StoreConfig store;
  LidarDeviceConfig lidar_device;
  BaseDeviceConfig base_device;
  ImuDeviceConfig imu_device;
  CanConfig can;
  DepthDeviceConfig depth_device;
  FrontEndConfig front_end;
  BackEndConfig back_end;
  OccupancyGridConfig map;
  LcmConfig lcm;
  RuntimeConfig runtime;
  OutputConfig output;
  LogConfig log;
  WebConfig web;
  /// Keys that were set and are renamed, or do nothing any more, one line each: `file:line:column: key: what; fix`.
  std::vector<std::string> notices = {};

  void visitSettings(auto& v) {
    v.section("", "what slamd does");
    v.robot("mode", mode,
            "Mode slam extends the newest map or begins a new one; mode localise follows the robot in a map that "
            "stays as it is.",
            "Set localise once the map is good and must not change any more.");
    v.section("store",
              "maps that outlast the daemon: keyframes, graph, grid, calibration, last pose; the service may write "
              "below /var/lib/slamd alone");
    store.visitSettings(v);
    v.section("lidar", "2D lidar: device, place on the robot, quality of its ranges");
    lidar_device.visitSettings(v);
    front_end.lidar.visitSettings(v);
    v.section("base", "wheels and the geometry of the base");
    base_device.visitSettings(v);
    v.expert("time_offset", front_end.intake.wheel_time_offset, "s", -1.0, 1.0,
             "This time is added to the stamps of the wheels' samples.");
    v.section("imu", "inertial unit");
    imu_device.visitSettings(v);
    v.expert("time_offset", front_end.intake.imu_time_offset, "s", -1.0, 1.0,
             "This time is added to the stamps of the IMU's samples.");
    v.section("can", "bus of wheels (ODrive CANSimple) and IMU (Xsens), for base.driver or imu.driver = \"can\"");
    can.visitSettings(v);
    v.section("depth", "depth camera: device, place on the robot, use of its images");
    depth_device.visitSettings(v);
    depth_device.projection.extrinsics.visitSettings(v);
    front_end.depth.visitSettings(v);
    depth_device.projection.visitSettings(v);
    v.section("map", "occupancy grid");
    map.visitSettings(v);
    v.section(
        "output",
        "files that are written; ~ and variables are not expanded; the service may write below /var/lib/slamd alone");
    output.visitSettings(v);
    v.section("log", "field log: a folder for each run, in files that slam-replay reads; see slamctl log");
    log.visitSettings(v);
    v.section("lcm", "messages over LCM");
    lcm.visitSettings(v);
    v.section("runtime", "threads, and the socket for commands");
    runtime.visitSettings(v);
    v.section("web", "slam-web, the page with the live map; a program of its own");
    web.visitSettings(v);
    front_end.visitSettings(v);
    v.section("loop_closure", "correction of the map where the robot comes back to an old part of it");
    v.expert("enabled", back_end.close_loops, "The map is corrected by loop closures; if false, it never is.");
    back_end.closure.visitSettings(v);
    front_end.keyframe.drift.visitSettings(v);
    v.section("relocalisation", "search for a lost robot in the whole map");
    back_end.relocalisation.visitSettings(v);
  }
};

/// Settings of the back end: its own, and those that it shares with the front end.
inline BackEndConfig backEndConfig(const Config& config) {
  BackEndConfig back_end = config.back_end;
  back_end.reference = config.front_end.reference;
  back_end.match = config.front_end.match;
  back_end.match.range_sigma = config.front_end.lidar.range_sigma;
  back_end.T_base_depth = config.depth_device.projection.extrinsics.levelled();
  back_end.localise_only = config.mode == RunMode::kLocalise;
  return back_end;
}

inline BaseKinematics kinematicsOf(const BaseDeviceConfig& base) {
  return {base.type, base.geometry.wheel_radius, base.geometry.half_track};
}

inline FrontEndConfig frontEndConfig(const Config& config) {
  FrontEndConfig front_end = config.front_end;
  front_end.ekf.holonomic = kinematicsOf(config.base_device).type != BaseType::kDifferential;
  front_end.ekf.limits = config.base_device.limits;
  front_end.localise_only = config.mode == RunMode::kLocalise;
  return front_end;
}

}  // namespace slam
