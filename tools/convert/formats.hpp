// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <filesystem>
#include <string>

#include "mapping/map_image.hpp"
#include "tools/convert/log_output.hpp"

/// One function per recorded format. Each reads all of its input, counts what it does not understand and goes on.
/// All throw std::runtime_error when the input cannot be opened, holds no sample, or the output cannot be written.
namespace slam {

/// CARMEN text logs: FLASER (with its odom_* as wheels) and ODOM lines.
ConvertReport convertCarmen(const std::filesystem::path& in, const std::filesystem::path& out);

/// Our log to CARMEN: FLASER lines with the wheels' pose at each scan, 180 or 360 degrees in equal steps.
ConvertReport convertToCarmen(const std::filesystem::path& in, const std::filesystem::path& out);

/// Comma-separated tables with a header line each, all on one clock; an empty path is left out.
struct CsvInput {
  std::filesystem::path
      scans;  ///< t_s, then raw words: range_cm = word & 8191 (8191: none), from -90 deg in equal steps
  std::filesystem::path speed;         ///< t_s,v_m_s
  std::filesystem::path imu;           ///< t_s | stamp_s, ax_g..az_g, wx_rad_s..wz_rad_s
  std::filesystem::path encoders;      ///< stamp_s, front right, front left, rear right, rear left ticks per interval
  double metres_per_tick = 0.0022168;  ///< of the encoders (254 mm wheel, 360 counts a turn)
  double half_track = 0.44;            ///< [m] of the encoders' base: half its effective track
  double imu_sign_z = 1.0;             ///< -1 where the IMU's z axis points down
};
ConvertReport convertCsv(const CsvInput& in, const std::filesystem::path& out);

/// Mines ParisTech rover (.dat): wheel ticks and a Hokuyo URG-04LX of 682 beams.
ConvertReport convertMines(const std::filesystem::path& in, const std::filesystem::path& out);

/// CMU Wean Hall (robotdata*.log): L lines in cm and rad, with the odometry they carry.
ConvertReport convertWean(const std::filesystem::path& in, const std::filesystem::path& out);

/// Map in the text format of Beesoft, as of Wean Hall: probabilities of being free, below 0 where unknown.
/// @throws std::runtime_error naming file and line when it is not one
MapImage readBeesoftMap(const std::filesystem::path& in);

/// What may go wrong with a robot's sensors, to be added to a log of one where it did not.
struct Disturbance {
  int jumps = 0;                  ///< sudden false motions at random times
  double jump_translation = 0.5;  ///< [m] of a jump, at most, in x and in y
  double jump_rotation = 0.785;   ///< [rad] of a jump, at most
  double noise = 0.0;             ///< [m per sqrt(m)] on distance, [rad per sqrt(m), rad per sqrt(rad)] on heading
  double distance_scale = 0.0;    ///< [1] error of the wheels' radius
  bool reverse_sign = false;      ///< driving backwards is reported as forwards
  double wheel_lag = 0.0;         ///< [s] a sample says where the wheels stood so long before its stamp
  bool wheels_swapped = false;    ///< left and right: the wheels turn the wrong way
  bool wheels_backwards = false;  ///< both count backwards
  bool gyro_reversed = false;     ///< its z axis points down
  bool lidar_upside_down = false;
  bool lidar_turned = false;    ///< by 180 degrees
  bool double_scans = false;    ///< every scan is sent twice
  bool time_backwards = false;  ///< all clocks are set back by 30 s in the middle, and every tenth scan by 0.3 s
  std::uint64_t seed = 1;
};
ConvertReport disturbLog(const std::filesystem::path& in, const std::filesystem::path& out,
                         const Disturbance& disturbance);

/// A reference trajectory that a log carries beside its sensors.
struct MbotTruth {
  std::filesystem::path file;  ///< TUM file to write; empty: none
  std::string channel =
      "SLAM_POSE";  ///< of pose_xyt_t: SLAM_POSE of the course's own SLAM, TRUE_POSE of motion capture
};

/// LCM event logs of Maebot and MBot: RPLidar, encoders and IMU.
ConvertReport convertMbot(const std::filesystem::path& in, const std::filesystem::path& out,
                          const MbotTruth& truth = {});

}  // namespace slam
