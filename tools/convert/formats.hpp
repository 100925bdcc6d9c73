// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <cstdint>
#include <filesystem>
#include <string>

#include "mapping/map_image.hpp"
#include "tools/convert/carmen.hpp"
#include "tools/convert/csv.hpp"
#include "tools/convert/mbot.hpp"
#include "tools/convert/recording.hpp"
#include "tools/faults/sensor_faults.hpp"

/// One function per recorded format. Each reads all of its input, counts what it does not understand and goes on.
/// All throw std::runtime_error when the input cannot be opened, holds no sample, or the output cannot be written.
namespace slam {

/// Our log to CARMEN: FLASER lines with the wheels' pose at each scan, 180 or 360 degrees in equal steps.
Recording convertToCarmen(const std::filesystem::path& in, const std::filesystem::path& out);

/// Our log to MCAP, for Foxglove: scans, depth and map in its own types, the rest as JSON of slamd's.
/// @param trajectory poses of base in map (TUM) in place of the log's own; empty: none
Recording convertToMcap(const std::filesystem::path& in, const std::filesystem::path& out,
                        const std::filesystem::path& trajectory);

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
