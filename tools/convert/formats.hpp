// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>

#include "mapping/map_image.hpp"
#include "tools/convert/recording.hpp"
#include "tools/faults/sensor_faults.hpp"

/// One function per recorded format. Each reads all of its input, counts what it does not understand and goes on.
/// All throw std::runtime_error when the input cannot be opened, holds no sample, or the output cannot be written.
namespace slam {

/// LCM logs with slamd's channels: its sensors and the configuration that a field log brings.
Recording convertLcm(const std::filesystem::path& in, const std::filesystem::path& out);

/// Recognises the input by its content and converts it: CARMEN, ROS 1 and 2, Maebot and MBot, LCM, Wean Hall, Mines, or
/// a table of scans.
/// @throws std::runtime_error also when it is none of these
Recording convertAny(const std::filesystem::path& in, const std::filesystem::path& out);

struct CarmenOptions {
  std::optional<double> period;  ///< [s] between scans, where neither the stamps nor the logger's are times
};

/// CARMEN text logs: FLASER and ROBOTLASER1 (with their odometry as wheels) and ODOM lines. Reads the input twice: what
/// the whole says of mount, stamps and ranges without return holds for each line.
Recording convertCarmen(const std::filesystem::path& in, const std::filesystem::path& out,
                        const CarmenOptions& options = {});

/// A reference trajectory that a log carries beside its sensors.
struct MbotTruth {
  std::filesystem::path file;  ///< TUM file to write; empty: none
  std::string channel =
      "SLAM_POSE";  ///< of pose_xyt_t: SLAM_POSE of the course's own SLAM, TRUE_POSE of motion capture
};

/// Of the robot's wheels. What is not given is that of the robots of the log's year.
struct MbotBase {
  std::optional<double> metres_per_tick;  ///< [m]
  std::optional<double> width;            ///< [m] between the wheels
  std::optional<double> wheel_radius;     ///< [m] by which the log's angles are made of ticks
};

/// LCM event logs of Maebot and MBot: RPLidar, encoders (or, without them, ODOMETRY) and IMU.
Recording convertMbot(const std::filesystem::path& in, const std::filesystem::path& out, const MbotTruth& truth = {},
                      const MbotBase& base = {});

/// It holds scans of these robots before any of slamd's.
bool isMbotLog(const std::filesystem::path& file);

/// Tables with a row for each sample, all on one clock; an empty path is left out. A first line of names is a header.
struct CsvInput {
  /// Ranges, with or without a stamp before them: in metres, or raw words of a SICK (range_cm = word & 8191, 8191:
  /// none, from -90 deg in equal steps). A header names the columns: t or a name with "time" or "stamp"; r0, range_1,
  /// ... or bearings [deg] for the ranges; x, y, theta for the odometry; angle_min, angle_max, angle_increment [rad].
  std::filesystem::path scans = {};
  std::filesystem::path speed = {};     ///< t_s,v_m_s
  std::filesystem::path imu = {};       ///< t_s | stamp_s, ax_g..az_g, wx_rad_s..wz_rad_s
  std::filesystem::path encoders = {};  ///< stamp_s, front right, front left, rear right, rear left ticks per interval
  double metres_per_tick = 0.0022168;   ///< of the encoders (254 mm wheel, 360 counts a turn)
  double wheel_radius = 0.127;          ///< [m] of the encoders' wheels
  double half_track = 0.44;             ///< [m] of the encoders' base: half its effective track
  double imu_sign_z = 1.0;              ///< -1 where the IMU's z axis points down
  std::string unit = {};                ///< of the ranges: "m", "cm", "mm", "words"; empty: found from the data
  std::string stamp_column = {};        ///< name, or number from 1; empty: found from the header or the data
  std::string first_range = {};         ///< column of the first range, as above; all behind it are ranges
  std::optional<double> field_of_view =
      {};  ///< [deg] from the first beam to the last, ahead in its middle; below 0: clockwise
  std::optional<double> first_bearing = {};  ///< [deg] counter-clockwise from ahead
  std::optional<double> period = {};         ///< [s] between scans without stamps
};

Recording convertCsv(const CsvInput& in, const std::filesystem::path& out);

/// What a bag leaves open. An empty topic is chosen from what the bag holds.
struct RosOptions {
  std::string scan = {}, odometry = {}, imu = {};            ///< topics
  std::optional<double> wheel_radius = {}, half_track = {};  ///< [m] makes odometry of joint states
};

/// Bags of ROS 1 and 2 (.bag, .db3, .mcap; a folder of split ones) to our log. Reads the input twice: the first time
/// for the topics, clocks and frames.
Recording convertRos(const std::filesystem::path& in, const std::filesystem::path& out, const RosOptions& options = {});

/// Our log to CARMEN: FLASER lines with the wheels' pose at each scan, 180 or 360 degrees in equal steps.
Recording convertToCarmen(const std::filesystem::path& in, const std::filesystem::path& out);

/// Our log to MCAP, for Foxglove: scans, depth and map in its own types, the rest as JSON of slamd's.
/// @param trajectory poses of base in map (TUM) in place of the log's own; empty: none
Recording convertToMcap(const std::filesystem::path& in, const std::filesystem::path& out,
                        const std::filesystem::path& trajectory);

/// Our log to a bag of ROS 2, SQLite (.db3) or MCAP (.mcap) by the name of `out`: LaserScan, Imu, JointState, Odometry,
/// PoseWithCovarianceStamped, OccupancyGrid and transforms.
Recording convertToBag(const std::filesystem::path& in, const std::filesystem::path& out);

/// Mines ParisTech rover (.dat): wheel ticks and a Hokuyo URG-04LX of 682 beams.
Recording convertMines(const std::filesystem::path& in, const std::filesystem::path& out);

/// CMU Wean Hall (robotdata*.log): L lines in cm and rad, with the odometry they carry.
Recording convertWean(const std::filesystem::path& in, const std::filesystem::path& out);

/// Map in the text format of Beesoft, as of Wean Hall: probabilities of being free, below 0 where unknown.
/// @throws std::runtime_error naming file and line when it is not one
MapImage readBeesoftMap(const std::filesystem::path& in);

/// What may go wrong with a robot's sensors, to be added to a log of one where it did not.
struct Disturbance {
  WheelFault wheels = {};
  ImuFault imu = {};
  LidarMountFault lidar = {};
  bool double_scans = false;    ///< every scan is sent twice
  bool time_backwards = false;  ///< all clocks are set back by 30 s in the middle, and every tenth scan by 0.3 s
  std::uint64_t seed = 1;
};
Recording disturbLog(const std::filesystem::path& in, const std::filesystem::path& out, const Disturbance& disturbance);

}  // namespace slam
