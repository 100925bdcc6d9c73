// SPDX-License-Identifier: BSD-3-Clause
#include <memory>
#include <numbers>
#include <stdexcept>

#include "tools/convert/formats.hpp"
#include "tools/convert/log_output.hpp"
#include "tools/convert/text_file.hpp"

namespace slam {
namespace {

constexpr std::size_t kBeams = 180;
constexpr double kMetresPerUnit = 0.01;
constexpr double kNoReturn = 81.0;        // [m] the SICK's largest reading
constexpr double kMostCells = 20000;      // of a map's side
constexpr std::int64_t kEpoch = 1000000;  // [us] the recording's clock begins at 0, which is no stamp

}  // namespace

Recording convertWean(const std::filesystem::path& in, const std::filesystem::path& out) {
  TextFile file(in);
  Recording recording;
  recording.format = "CMU Wean Hall log";
  recording.robot = {.lidar_x = 0.25,
                     .mount_source = "the description of this robot",
                     .range_min = 0.05,
                     .range_max = 50.0,
                     .range_sigma = 0.02};
  LogOutput log;
  auto scan = std::make_unique<LaserScan>();
  scan->range_min = 0.05F;
  scan->range_max = 80.0F;
  std::int64_t arrival = 0;
  int odometry_lines = 0;
  for (std::string line; file.next(line);) {
    const auto words = splitWords(line);
    if (words.empty()) continue;
    const bool laser = words[0] == "L", odometry = words[0] == "O";
    const std::size_t expected = laser ? 7 + kBeams + 1 : 5;
    const auto numbers = (laser || odometry) && words.size() == expected ? toNumbers(words, 1) : std::nullopt;
    const auto seconds = numbers ? toMicroseconds(words.back()) : std::nullopt;
    if (!seconds || *seconds < 0) {
      recording.reject(recording.sensor(laser      ? "L"
                                        : odometry ? "O"
                                                   : "other lines"),
                       in.filename().string() + ":" + std::to_string(file.lineNumber()),
                       "not an O line of 5 or an L line of 188 words");
      continue;
    }
    // An L line's odometry was interpolated to the moment of the scan, which lies before the line's stamp; an O line's
    // is of its stamp. Mixed they would go to and fro, so the scans' own are used.
    if (!laser) {
      ++odometry_lines;
      recording.sensor("O").use(*seconds + kEpoch);
      continue;
    }
    const std::int64_t utime = *seconds + kEpoch;
    arrival = std::max(arrival, utime);
    const WheelSample wheels{fromMicroseconds(utime),
                             {(*numbers)[0] * kMetresPerUnit, (*numbers)[1] * kMetresPerUnit, (*numbers)[2]}};
    log.add(arrival, wheels, utime);
    ++recording.wheels;
    scan->stamp = fromMicroseconds(utime);
    scan->size = 0;
    for (std::size_t i = 0; i < kBeams; ++i) {
      const double range = (*numbers)[6 + i] * kMetresPerUnit;
      const double bearing = -std::numbers::pi / 2.0 + std::numbers::pi / kBeams * static_cast<double>(i);
      scan->push({.range = range >= kNoReturn ? 0.0F : returnedRange(range), .bearing = static_cast<float>(bearing)});
    }
    log.add(arrival, *scan, utime);
    recording.useScan(recording.sensor("L"), utime);
  }
  reportDamage(file, in, recording);
  if (odometry_lines > 0) {
    recording.unused.push_back(std::to_string(odometry_lines) +
                               " O lines: the L lines carry the odometry of each scan");
  }
  log.write(out, &recording);
  return recording;
}

MapImage readBeesoftMap(const std::filesystem::path& in) {
  TextFile file(in);
  MapImage image;
  image.resolution = 0.0;
  double shift_x = 0.0, shift_y = 0.0;
  int column = 0;  // a line of numbers is a column of the map: x grows from line to line, y within one
  for (std::string line; file.next(line);) {
    const auto words = splitWords(line);
    if (words.empty()) continue;
    const auto last = toNumber(words.back());
    const auto complain = [&](const std::string& what) {
      throw std::runtime_error(in.string() + ":" + std::to_string(file.lineNumber()) + ": " + what);
    };
    if (!last) complain("not a number at the end of the line");
    if (words[0] == "robot_specifications->resolution") {
      image.resolution = *last * kMetresPerUnit;
    } else if (words[0] == "robot_specifications->autoshifted_x") {
      shift_x = *last * kMetresPerUnit;
    } else if (words[0] == "robot_specifications->autoshifted_y") {
      shift_y = *last * kMetresPerUnit;
    } else if (words[0] == "global_map[0]:") {
      const auto size = toNumbers(words, 1);
      if (!size || size->size() != 2 || (*size)[0] < 1.0 || (*size)[1] < 1.0 || (*size)[0] > kMostCells ||
          (*size)[1] > kMostCells) {
        complain("no size after global_map[0]:");
      }
      image.width = static_cast<int>((*size)[0]);
      image.height = static_cast<int>((*size)[1]);
      image.cells.assign(static_cast<std::size_t>(image.width) * static_cast<std::size_t>(image.height),
                         MapImage::kUnknown);
    } else if (image.width > 0) {
      const auto cells = toNumbers(words);
      if (!cells || static_cast<int>(cells->size()) != image.height || column >= image.width) {
        complain("not one of " + std::to_string(image.width) + " lines of " + std::to_string(image.height) + " cells");
      }
      for (int row = 0; row < image.height; ++row) {
        const double free = (*cells)[static_cast<std::size_t>(row)];  // below 0: unknown
        if (free >= 0.0) image.at(column, row) = classify(1.0 - free);
      }
      ++column;
    }
  }
  if (file.damaged() || image.width == 0 || column != image.width || !(image.resolution > 0.0)) {
    throw std::runtime_error(in.string() + ": not a whole map with its resolution and size");
  }
  image.origin_x = -shift_x;
  image.origin_y = -shift_y;
  return image;
}

}  // namespace slam
