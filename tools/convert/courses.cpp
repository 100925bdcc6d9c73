// SPDX-License-Identifier: BSD-3-Clause
// Finished data sets of robots whose measures are known: Mines ParisTech rover and CMU Wean Hall.
#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <stdexcept>

#include "tools/convert/assembler.hpp"
#include "tools/convert/formats.hpp"
#include "tools/convert/text_file.hpp"

namespace slam {
namespace {

class Mines : public Reader {
 public:
  explicit Mines(const std::filesystem::path& in) : Reader(in, 0.06F, 4.1F) {}

  void read(Assembler& to) override {
    constexpr double kRadiansPerTick = 2.0 * std::numbers::pi / 2000.0;
    constexpr double kLatest = 2.3e15, kMostTicks = 1e15;  // [us] slamd's messages carry no later times; [1]
    constexpr std::size_t kFirstRange = 24, kBeams = 682, kMargin = 70;
    constexpr double kFirstBearing = -2.0 * std::numbers::pi / 3.0,
                     kStep = (4.0 * std::numbers::pi / 3.0) / (kBeams - 1);  // [rad] 240 deg in all
    Pose2 pose;
    std::optional<std::array<double, 2>> last;  // [1] ticks
    forEachLine(in_, to, [&](const auto& words, Origin at) {
      at.sensor = "lines of 706 numbers";
      const auto numbers = words.size() >= kFirstRange + kBeams ? toNumbers(words) : std::nullopt;
      const bool timed = numbers && (*numbers)[0] >= 1.0 && (*numbers)[0] < kLatest;
      const std::array<double, 2> ticks{timed ? (*numbers)[2] : 0.0, timed ? (*numbers)[3] : 0.0};
      if (!timed || std::max(std::abs(ticks[0]), std::abs(ticks[1])) > kMostTicks) {
        return to.refuse(at, "not 24 values and 682 ranges");
      }
      constexpr double kMetresPerTick = 2.0 * std::numbers::pi * kWheelRadius / 2000.0;
      if (last) {
        pose = pose * travelled((ticks[0] - (*last)[0]) * kMetresPerTick, (ticks[1] - (*last)[1]) * kMetresPerTick,
                                kHalfTrack);
      }
      last = ticks;
      at.stamp = at.received = static_cast<std::int64_t>((*numbers)[0]);
      scan_->size = 0;
      for (std::size_t i = kMargin; i < kBeams; ++i) {
        scan_->push({.range = returnedRange((*numbers)[kFirstRange + i] * 1e-3),
                     .bearing = static_cast<float>(kFirstBearing + kStep * static_cast<double>(i))});
      }
      to.wheels(at.of(""), pose, std::array{ticks[0] * kRadiansPerTick, ticks[1] * kRadiansPerTick});
      to.scan(at, *scan_);
    });
  }

  void finish(Assembler& to) override {
    to.recording.format = "Mines ParisTech rover";
    to.recording.robot = {.lidar_x = 0.145,
                          .mount_source = "the description of this robot",
                          .range_min = 0.06,
                          .range_max = 4.0,
                          .range_sigma = 0.02,
                          .wheel_radius = kWheelRadius,
                          .half_track = kHalfTrack};
  }

 private:
  static constexpr double kWheelRadius = 0.077, kHalfTrack = 0.165;  // [m]
};

constexpr double kMetresPerUnit = 0.01;  // of Wean Hall

class Wean : public Reader {
 public:
  explicit Wean(const std::filesystem::path& in) : Reader(in, 0.05F, 80.0F) {}

  void read(Assembler& to) override {
    constexpr std::size_t kBeams = 180;
    constexpr double kNoReturn = 81.0;        // [m] the SICK's largest reading
    constexpr std::int64_t kEpoch = 1000000;  // [us] the recording's clock begins at 0, which is no stamp
    std::int64_t arrival = 0;
    forEachLine(in_, to, [&](const auto& words, Origin at) {
      const bool laser = words[0] == "L", odometry = words[0] == "O";
      at.sensor = laser || odometry ? std::string(words[0]) : "other lines";
      const std::size_t expected = laser ? 7 + kBeams + 1 : 5;
      const auto numbers = (laser || odometry) && words.size() == expected ? toNumbers(words, 1) : std::nullopt;
      const auto seconds = numbers ? toMicroseconds(words.back()) : std::nullopt;
      if (!seconds || *seconds < 0) return to.refuse(at, "not an O line of 5 or an L line of 188 words");
      at.stamp = *seconds + kEpoch;
      // An L line's odometry was interpolated to the moment of the scan, which lies before the line's stamp; an O
      // line's is of its stamp. Mixed they would go to and fro, so the scans' own are used.
      if (!laser) {
        if (!to.surveying()) to.rows(at).use(at.stamp);
        return;
      }
      at.received = arrival = std::max(arrival, at.stamp);
      to.wheels(at.of(""), {(*numbers)[0] * kMetresPerUnit, (*numbers)[1] * kMetresPerUnit, (*numbers)[2]});
      scan_->size = 0;
      for (std::size_t i = 0; i < kBeams; ++i) {
        const double range = (*numbers)[6 + i] * kMetresPerUnit;
        const double bearing = -std::numbers::pi / 2.0 + std::numbers::pi / kBeams * static_cast<double>(i);
        scan_->push(
            {.range = range >= kNoReturn ? 0.0F : returnedRange(range), .bearing = static_cast<float>(bearing)});
      }
      to.scan(at, *scan_);
    });
  }

  void finish(Assembler& to) override {
    to.recording.format = "CMU Wean Hall log";
    to.recording.robot = {.lidar_x = 0.25,
                          .mount_source = "the description of this robot",
                          .range_min = 0.05,
                          .range_max = 50.0,
                          .range_sigma = 0.02};
    for (const SensorRows& rows : to.recording.sensors) {
      if (rows.name != "O" || rows.used == 0) continue;
      to.recording.unused.push_back(std::to_string(rows.used) +
                                    " O lines: the L lines carry the odometry of each scan");
    }
  }
};

}  // namespace

Recording convertMines(const std::filesystem::path& in, const std::filesystem::path& out) {
  return assemble(Mines(in), out);
}

Recording convertWean(const std::filesystem::path& in, const std::filesystem::path& out) {
  return assemble(Wean(in), out);
}

MapImage readBeesoftMap(const std::filesystem::path& in) {
  constexpr double kMostCells = 20000;  // of a map's side
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
