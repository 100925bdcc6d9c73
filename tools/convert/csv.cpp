// SPDX-License-Identifier: BSD-3-Clause
#include "tools/convert/csv.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <functional>
#include <limits>
#include <memory>
#include <numbers>
#include <stdexcept>

#include "core/samples.hpp"
#include "core/scan.hpp"
#include "tools/convert/csv_table.hpp"
#include "tools/convert/log_output.hpp"
#include "tools/convert/range_census.hpp"
#include "tools/convert/text_file.hpp"

namespace slam {
namespace {

constexpr double kStandardGravity = 9.80665;  // [m/s^2]
constexpr std::int64_t kEpoch = 1000000;      // [us] added to stamps: a recording that begins at 0 has no stamp of 0

/// Calls row(utime, words) for each line with `columns` or more words; the header and comments are passed over.
void forEachRow(const std::filesystem::path& path, std::size_t columns, Recording& recording, SensorRows& rows,
                const std::function<bool(std::int64_t, const std::vector<std::string_view>&)>& row) {
  TextFile file(path);
  for (std::string line; file.next(line);) {
    const auto words = splitWords(line);
    if (words.empty() || words[0].front() == '#') continue;
    if (file.lineNumber() == 1 && !toNumber(words[0])) continue;
    const auto utime = toMicroseconds(words[0]);
    if (!utime || words.size() < columns || !row(*utime + kEpoch, words)) {
      recording.reject(rows, path.filename().string() + ":" + std::to_string(file.lineNumber()),
                       "not a row of numbers");
    }
  }
  reportDamage(file, path, recording);
}

/// What the ranges of a table are, by all of its rows.
struct ScanSurvey {
  std::string_view unit;     // "m", "cm", "mm", "words"
  double stamp_unit = 1e-6;  // [us] of a stamp's unit, inverted: stamp / stamp_unit is in microseconds
  RangeCensus census;        // in metres
};

double metresPer(std::string_view unit) { return unit == "mm" ? 1e-3 : unit == "cm" ? 1e-2 : 1.0; }

/// [us] per unit of stamps whose usual step is that of a lidar.
double microsecondsPer(double step, const std::string& name) {
  if (name.ends_with("_ns") || name.find("nano") != std::string::npos) return 1e-3;
  if (name.ends_with("_us") || name.find("utime") != std::string::npos) return 1.0;
  if (name.ends_with("_ms")) return 1e3;
  if (name.ends_with("_s") || name.ends_with("[s]")) return 1e6;
  return step < 4.0 ? 1e6 : step < 4e3 ? 1e3 : step < 4e6 ? 1.0 : 1e-3;
}

ScanSurvey surveyed(const CsvInput& in, CsvColumns& columns) {
  constexpr std::size_t kMostSteps = 100000;
  double largest = 0.0;
  bool fractions = false, has_none_word = false;
  std::vector<std::size_t> numbers(columns.count), below(columns.count);
  std::vector<double> steps;
  std::optional<double> last;
  forEachCsvRow(in.scans, columns, [&](const auto& cells, int) {
    if (cells.size() != columns.count) return;
    if (columns.stamp && *columns.stamp < cells.size() && steps.size() < kMostSteps) {
      const auto stamp = cellNumber(cells[*columns.stamp]);
      if (stamp && last && *stamp > *last) steps.push_back(*stamp - *last);
      last = stamp;
    }
    for (const std::size_t at : columns.ranges) {
      const auto range = cellNumber(cells[at]);
      // Without a header or a second row the stamp may still be among them: it is the first, and no word.
      if (!range || std::isnan(*range) || (at == 0 && columns.names.empty())) continue;
      ++numbers[at];
      below[at] += *range < 0.0 && *range != -1.0 ? 1 : 0;  // -1: no return
      largest = std::max(largest, *range);
      fractions |= *range != std::floor(*range);
      has_none_word |= *range == 8191.0;
    }
  });
  constexpr std::size_t kFewBelow = 10;  // one of so many
  for (const std::size_t at : columns.ranges) {
    if (kFewBelow * below[at] <= numbers[at]) continue;
    throw std::runtime_error(in.scans.string() + ": many of the numbers in column " + std::to_string(at + 1) +
                             " are below 0: they are no ranges of a lidar; name the first of these with --first-range");
  }
  ScanSurvey survey;
  survey.unit = in.unit.empty() ? columns.unit : in.unit;
  if (survey.unit.empty()) {
    constexpr double kFarthest = 200.0, kLargestWord = 65535.0;
    if (largest <= kFarthest && (fractions || !columns.names.empty())) {
      survey.unit = "m";
    } else if (!fractions && largest <= kLargestWord && (largest > 8191.0 || has_none_word)) {
      survey.unit = "words";
    } else {
      throw std::runtime_error(in.scans.string() + ": ranges up to " + std::to_string(std::lround(largest)) +
                               " are no metres" + (fractions ? "" : ", without a single fraction") +
                               "; give their unit with --unit m, cm, mm or words (of a SICK)");
    }
  }
  if (survey.unit == "words" && !columns.stamp) columns.stamp = 0;  // such a table always has one
  std::erase(columns.ranges, columns.stamp.value_or(columns.count));
  if (!steps.empty()) {
    std::nth_element(steps.begin(), steps.begin() + static_cast<std::ptrdiff_t>(steps.size() / 2), steps.end());
  }
  const std::string name = columns.stamp && !columns.names.empty() ? columns.names[*columns.stamp] : std::string();
  survey.stamp_unit = columns.stamp_in_ns ? 1e-3 : microsecondsPer(steps.empty() ? 0.0 : steps[steps.size() / 2], name);
  if (columns.nanoseconds) survey.stamp_unit = 1e6;
  if (survey.unit == "words") return survey;
  forEachCsvRow(in.scans, columns, [&](const auto& cells, int) {
    for (std::size_t i = 0; i < columns.ranges.size(); ++i) {
      const auto range = columns.ranges[i] < cells.size() ? cellNumber(cells[columns.ranges[i]]) : std::nullopt;
      if (range) survey.census.add(i, columns.ranges.size(), *range * metresPer(survey.unit));
    }
  });
  return survey;
}

constexpr double kRadians = std::numbers::pi / 180.0;

/// [rad] of each beam, from the options, the header, or what lidars of so many beams mostly have.
std::vector<double> bearingsOf(const CsvInput& in, const CsvColumns& columns, bool words, Recording& recording) {
  const std::size_t n = columns.ranges.size();
  if (!columns.bearings.empty() && !in.field_of_view && !in.first_bearing) return columns.bearings;
  double degrees = in.field_of_view.value_or(0.0);
  if (!in.field_of_view) {
    const bool half = words || n == 180 || n == 181 || n == 361 || n == 721;
    const bool hokuyo = n == 682 || n == 683 || n == 726 || n == 769,
               wide = n == 271 || n == 541 || n == 811 || n == 1081;
    degrees = half ? 180.0 : wide ? 270.0 : hokuyo ? 240.0 : n >= 360 ? 360.0 : 180.0;
    const bool told = columns.angle_min && (columns.angle_max || columns.angle_increment);
    if (!words && !told) {
      char text[160];
      std::snprintf(text, sizeof(text),
                    "the table does not say where its %zu beams point: %.0f degrees were taken, ahead in their middle; "
                    "give --fov",
                    n, degrees);
      recording.notes.emplace_back(text);
    }
  }
  const bool turn = std::abs(degrees) > 359.0;
  const double divisions = static_cast<double>(turn || (n == 180 && degrees == 180.0) ? n : n - 1);
  const double first = in.first_bearing.value_or(-0.5 * degrees);
  std::vector<double> bearings;
  for (std::size_t i = 0; i < n; ++i)
    bearings.push_back((first + degrees * static_cast<double>(i) / divisions) * kRadians);
  return bearings;
}

/// Ranges in metres or parts of it.
class ScanRows {
 public:
  ScanRows(const CsvInput& in, const CsvColumns& columns, const ScanSurvey& survey, Recording& recording)
      : in_(in),
        columns_(columns),
        survey_(survey),
        words_(survey.unit == "words"),
        bearings_(bearingsOf(in, columns, words_, recording)),
        codes_(survey.census.codes()) {
    scan_->range_min = words_ ? 0.1F : 0.02F;
    scan_->range_max = words_ ? 80.0F : 200.0F;
  }

  /// @return what is wrong, or nullptr
  const char* read(const std::vector<std::string_view>& cells) {
    constexpr double kPeriod = 0.1;  // [s] where nothing is said
    if (cells.size() != columns_.count) return "not as many columns as in most rows";
    if (!columns_.stamp) {
      utime_ = kEpoch + std::llround(1e6 * in_.period.value_or(kPeriod) * rows_);
    } else {
      const std::string_view cell = cells[*columns_.stamp];
      const auto number = cellNumber(cell);
      if (!number || std::isnan(*number)) return "its stamp is not a number";
      const double microseconds = *number * survey_.stamp_unit;
      if (!(std::abs(microseconds) < 2.3e15)) return "its stamp is not a time";
      const auto exact = survey_.stamp_unit == 1e6 ? toMicroseconds(cell) : std::nullopt;
      utime_ = exact.value_or(std::llround(microseconds)) + kEpoch;
      if (columns_.nanoseconds) utime_ += std::llround(1e-3 * numberIn(cells, columns_.nanoseconds).value_or(0.0));
      if (utime_ <= 0) return "its stamp is not a time";
    }
    double first = 0.0, step = 0.0;
    const bool told = anglesOf(cells, first, step);
    const double each = numberIn(cells, columns_.time_increment).value_or(0.0);
    time_step_ = each > 0.0 && each < 1.0 ? each : 0.0;
    const double most = numberIn(cells, columns_.range_max).value_or(0.0);
    farthest_ = most > 0.0 ? most : std::numeric_limits<double>::infinity();
    scan_->stamp = fromMicroseconds(utime_);
    scan_->size = 0;
    for (std::size_t i = 0; i < columns_.ranges.size(); ++i) {
      const auto number = cellNumber(cells[columns_.ranges[i]]);
      if (!number) return "a range that is not a number";
      const double bearing = wrapAngle(told ? first + step * static_cast<double>(i) : bearings_[i]);
      if (!push(*number, bearing)) return "a word that is none of a SICK";
    }
    ++rows_;
    return nullptr;
  }
  const LaserScan& scan() const { return *scan_; }
  std::int64_t utime() const { return utime_; }
  std::optional<Pose2> pose(const std::vector<std::string_view>& cells) const {
    if (!columns_.x || !columns_.y || !columns_.theta) return std::nullopt;
    const auto x = numberIn(cells, columns_.x), y = numberIn(cells, columns_.y),
               theta = numberIn(cells, columns_.theta);
    return x && y && theta ? std::optional(Pose2{*x, *y, *theta}) : std::nullopt;
  }
  /// [m] beyond which nothing is a return
  double rangeMax() const { return words_ ? 50.0 : survey_.census.limit(); }

 private:
  bool push(double number, double bearing) {
    if (words_) {
      constexpr int kRangeMask = 8191, kNone = 8191;
      if (!(number >= 0 && number <= 65535)) return false;
      const int word = static_cast<int>(number), centimetres = word & kRangeMask;
      scan_->push({.range = centimetres == kNone ? 0.0F : static_cast<float>(centimetres) * 0.01F,
                   .bearing = static_cast<float>(bearing),
                   .intensity = static_cast<float>(word >> 13)});
      return true;
    }
    const double range = number * metresPer(survey_.unit);
    const bool code = std::any_of(codes_.begin(), codes_.end(), [&](double none) { return isCode(range, none); });
    scan_->push({.range = code || range >= farthest_ ? 0.0F : returnedRange(range),
                 .bearing = static_cast<float>(bearing),
                 .time_offset = static_cast<float>(time_step_ * scan_->size)});
    return true;
  }
  /// Bearings that the row itself has. @return false: it has none
  bool anglesOf(const std::vector<std::string_view>& cells, double& first, double& step) const {
    if (!columns_.angle_min || in_.field_of_view || in_.first_bearing) return false;
    const auto least = numberIn(cells, columns_.angle_min), most = numberIn(cells, columns_.angle_max),
               increment = numberIn(cells, columns_.angle_increment);
    if (!least || (!most && !increment)) return false;
    const auto last = static_cast<double>(columns_.ranges.size() - 1);
    first = *least;
    step = increment ? *increment : (*most - *least) / last;
    constexpr double kMost = 2.0 * std::numbers::pi + 0.02;  // [rad] more are degrees
    if (std::max(std::abs(first), std::abs(step * last)) > kMost) {
      first *= kRadians;
      step *= kRadians;
    }
    return true;
  }
  static std::optional<double> numberIn(const std::vector<std::string_view>& cells, std::optional<std::size_t> at) {
    const auto number = at ? cellNumber(cells[*at]) : std::nullopt;
    return number && !std::isnan(*number) ? number : std::nullopt;
  }

  const CsvInput& in_;
  const CsvColumns& columns_;
  const ScanSurvey& survey_;
  bool words_;
  std::vector<double> bearings_, codes_;
  std::unique_ptr<LaserScan> scan_ = std::make_unique<LaserScan>();
  std::int64_t utime_ = 0;
  double time_step_ = 0.0, farthest_ = 0.0;  // [s] from beam to beam, [m] no return from here on
  int rows_ = 0;
};

void addScans(const CsvInput& in, Recording& recording, LogOutput& log) {
  CsvColumns columns = csvColumns(in.scans, in.stamp_column, in.first_range);
  const ScanSurvey survey = surveyed(in, columns);
  if (columns.ranges.size() < 2 || columns.ranges.size() > static_cast<std::size_t>(LaserScan::kCapacity)) {
    throw std::runtime_error(in.scans.string() + ": " + std::to_string(columns.ranges.size()) +
                             " columns of ranges; a scan has 2 to " + std::to_string(LaserScan::kCapacity));
  }
  constexpr std::size_t kFewestGuessed = 8;
  if (columns.guessed && columns.ranges.size() < kFewestGuessed) {
    throw std::runtime_error(in.scans.string() + ": " + std::to_string(columns.ranges.size()) +
                             " columns of numbers without names are no ranges of scans; is each row of one beam? A "
                             "table of scans has a row for each scan; name the first range with --first-range");
  }
  ScanRows reader(in, columns, survey, recording);
  const std::string name = in.scans.filename().string();
  SensorRows& rows = recording.sensor(name);
  const bool poses = columns.x && columns.y && columns.theta;
  forEachCsvRow(in.scans, columns, [&](const auto& cells, int line) {
    const std::string where = name + ":" + std::to_string(line);
    if (const char* wrong = reader.read(cells)) return recording.reject(rows, where, wrong);
    if (poses) {
      SensorRows& odometry = recording.sensor(name + " (x, y, theta)");
      if (const auto pose = reader.pose(cells)) {
        log.add(reader.utime(), WheelSample{reader.scan().stamp, *pose}, reader.utime());
        recording.useWheels(odometry, reader.utime());
      } else {
        recording.reject(odometry, where, "x, y or theta is not a number");
      }
    }
    log.add(reader.utime(), reader.scan(), reader.utime());
    recording.useScan(rows, reader.utime());
  });
  if (rows.used == 0) {
    throw std::runtime_error(in.scans.string() +
                             ": no row of it could be used as a scan; first refused: " + recording.first_rejection);
  }
  if (!columns.stamp) {
    recording.notes.push_back(in.period ? "the table has no stamps: --period was used"
                                        : "the table has no stamps: 0.1 s from scan to scan was taken; give --period");
  }
  recording.robot.range_min = survey.unit == "words" ? 0.1 : 0.05;
  recording.robot.range_max = reader.rangeMax();
  TextFile file(in.scans);
  for (std::string line; file.next(line);) {
  }
  reportDamage(file, in.scans, recording);
}

}  // namespace

Recording convertCsv(const CsvInput& in, const std::filesystem::path& out) {
  Recording recording;
  recording.format = "tables of numbers";
  LogOutput log;
  if (!in.speed.empty()) {
    Pose2 pose;
    std::int64_t previous = -1;
    SensorRows& rows = recording.sensor(in.speed.filename().string());
    forEachRow(in.speed, 2, recording, rows, [&](std::int64_t utime, const auto& words) {
      const auto speed = toNumber(words[1]);
      if (!speed) return false;
      // The speed is the mean since the row before it; there is no turn rate.
      if (previous >= 0) pose.x += *speed * static_cast<double>(utime - previous) * 1e-6;
      previous = utime;
      log.add(utime, WheelSample{fromMicroseconds(utime), pose, false}, utime);
      recording.useWheels(rows, utime);
      return true;
    });
  }
  if (!in.encoders.empty()) {
    Pose2 pose;
    double angle_left = 0.0, angle_right = 0.0;
    SensorRows& rows = recording.sensor(in.encoders.filename().string());
    forEachRow(in.encoders, 5, recording, rows, [&](std::int64_t utime, const auto& words) {
      const auto ticks = toNumbers(words, 1);
      if (!ticks) return false;
      const double right = 0.5 * ((*ticks)[0] + (*ticks)[2]) * in.metres_per_tick;
      const double left = 0.5 * ((*ticks)[1] + (*ticks)[3]) * in.metres_per_tick;
      pose = pose * exp({0.5 * (left + right), 0.0, (right - left) / (2.0 * in.half_track)});
      angle_left += left / in.wheel_radius;
      angle_right += right / in.wheel_radius;
      log.add(utime, WheelSample{fromMicroseconds(utime), pose}, utime, std::array{angle_left, angle_right});
      recording.useWheels(rows, utime);
      return true;
    });
    recording.robot.wheel_radius = in.wheel_radius;
    recording.robot.half_track = in.half_track;
  }
  if (!in.imu.empty()) {
    SensorRows& rows = recording.sensor(in.imu.filename().string());
    forEachRow(in.imu, 7, recording, rows, [&](std::int64_t utime, const auto& words) {
      Eigen::Vector3d accel, gyro;
      for (int i = 0; i < 3; ++i) {
        const auto a = toNumber(words[static_cast<std::size_t>(1 + i)]);
        const auto w = toNumber(words[static_cast<std::size_t>(4 + i)]);
        if (!a || !w) return false;
        accel[i] = *a * kStandardGravity;
        gyro[i] = *w;
      }
      gyro.z() *= in.imu_sign_z;
      accel.z() *= in.imu_sign_z;
      log.add(utime, ImuSample{fromMicroseconds(utime), gyro, accel}, utime);
      recording.useImu(rows, utime);
      return true;
    });
  }
  if (!in.scans.empty()) addScans(in, recording, log);
  log.write(out, &recording);
  return recording;
}

}  // namespace slam
