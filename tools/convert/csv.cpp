// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <functional>
#include <limits>
#include <numbers>
#include <optional>
#include <stdexcept>

#include "tools/convert/assembler.hpp"
#include "tools/convert/csv_table.hpp"
#include "tools/convert/formats.hpp"
#include "tools/convert/text_file.hpp"

namespace slam {
namespace {

constexpr std::int64_t kCsvEpoch = 1000000;  // [us] added to stamps: a recording that begins at 0 has no stamp of 0

/// [us] per unit of stamps whose usual step is that of a lidar.
double microsecondsPer(double step, const std::string& name) {
  if (name.ends_with("_ns") || name.find("nano") != std::string::npos) return 1e-3;
  if (name.ends_with("_us") || name.find("utime") != std::string::npos) return 1.0;
  if (name.ends_with("_ms")) return 1e3;
  if (name.ends_with("_s") || name.ends_with("[s]")) return 1e6;
  return step < 4.0 ? 1e6 : step < 4e3 ? 1e3 : step < 4e6 ? 1.0 : 1e-3;
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

/// A table of scans: ranges in metres, parts of it, or words of a SICK.
class ScanTable {
 public:
  /// @throws std::runtime_error when it is none
  ScanTable(const CsvInput& in, Recording& recording);

  /// Fills the scan. @return what is wrong, or nullptr
  const char* read(const std::vector<std::string_view>& cells, Origin& at, LaserScan& scan) {
    constexpr double kPeriod = 0.1;  // [s] where nothing is said
    if (cells.size() != columns_.count) return "not as many columns as in most rows";
    if (!columns_.stamp) {
      at.stamp = kCsvEpoch + std::llround(1e6 * in_.period.value_or(kPeriod) * rows_);
    } else {
      const std::string_view cell = cells[*columns_.stamp];
      const auto number = cellNumber(cell);
      if (!number || std::isnan(*number)) return "its stamp is not a number";
      const double microseconds = *number * stamp_unit_;
      if (!(std::abs(microseconds) < 2.3e15)) return kNoTime;
      const auto exact = stamp_unit_ == 1e6 ? toMicroseconds(cell) : std::nullopt;
      at.stamp = exact.value_or(std::llround(microseconds)) + kCsvEpoch;
      if (columns_.nanoseconds) at.stamp += std::llround(1e-3 * numberIn(cells, columns_.nanoseconds).value_or(0.0));
      if (at.stamp <= 0) return kNoTime;
    }
    double first = 0.0, step = 0.0;
    const bool told = anglesOf(cells, first, step);
    const double each = numberIn(cells, columns_.time_increment).value_or(0.0);
    time_step_ = each > 0.0 && each < 1.0 ? each : 0.0;
    const double most = numberIn(cells, columns_.range_max).value_or(0.0);
    farthest_ = most > 0.0 ? most : std::numeric_limits<double>::infinity();
    at.received = at.stamp;
    written_.clear();
    scan.range_min = words_ ? 0.1F : 0.02F;
    scan.range_max = words_ ? 80.0F : 200.0F;
    scan.size = 0;
    for (std::size_t i = 0; i < columns_.ranges.size(); ++i) {
      const auto number = cellNumber(cells[columns_.ranges[i]]);
      if (!number) return "a range that is not a number";
      const double bearing = wrapAngle(told ? first + step * static_cast<double>(i) : bearings_[i]);
      if (!push(scan, *number, bearing)) return "a word that is none of a SICK";
    }
    ++rows_;
    return nullptr;
  }
  std::optional<Pose2> pose(const std::vector<std::string_view>& cells) const {
    const auto x = numberIn(cells, columns_.x), y = numberIn(cells, columns_.y),
               theta = numberIn(cells, columns_.theta);
    return x && y && theta ? std::optional(Pose2{*x, *y, *theta}) : std::nullopt;
  }
  const CsvColumns& columns() const { return columns_; }
  bool words() const { return words_; }
  /// [m] ranges of the row that was read, as they stand there; words have none
  std::span<const double> written() const { return written_; }
  void rewind() { rows_ = 0; }

 private:
  void findUnits();

  bool push(LaserScan& scan, double number, double bearing) {
    if (words_) {
      constexpr int kRangeMask = 8191, kNone = 8191;
      if (!(number >= 0 && number <= 65535)) return false;
      const int word = static_cast<int>(number), centimetres = word & kRangeMask;
      scan.push({.range = centimetres == kNone ? 0.0F : static_cast<float>(centimetres) * 0.01F,
                 .bearing = static_cast<float>(bearing),
                 .intensity = static_cast<float>(word >> 13)});
      return true;
    }
    const double range = number * metres_;
    written_.push_back(range);
    scan.push({.range = range >= farthest_ ? 0.0F : returnedRange(range),
               .bearing = static_cast<float>(bearing),
               .time_offset = static_cast<float>(time_step_ * scan.size)});
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
  CsvColumns columns_;
  double metres_ = 1.0, stamp_unit_ = 1e6;  // [m] of a range's unit, [us] of a stamp's
  bool words_ = false;
  std::vector<double> bearings_, written_;   // [rad], [m]
  double time_step_ = 0.0, farthest_ = 0.0;  // [s] from beam to beam, [m] no return from here on
  int rows_ = 0;
};

/// What stamps and ranges are, by all rows.
void ScanTable::findUnits() {
  constexpr std::size_t kMostSteps = 100000;
  double largest = 0.0;
  bool fractions = false, has_none_word = false;
  std::vector<std::size_t> numbers(columns_.count), below(columns_.count);
  std::vector<double> steps;
  std::optional<double> last;
  forEachCsvRow(in_.scans, columns_, [&](const auto& cells, int) {
    if (cells.size() != columns_.count) return;
    if (columns_.stamp && *columns_.stamp < cells.size() && steps.size() < kMostSteps) {
      const auto stamp = cellNumber(cells[*columns_.stamp]);
      if (stamp && last && *stamp > *last) steps.push_back(*stamp - *last);
      last = stamp;
    }
    for (const std::size_t at : columns_.ranges) {
      const auto range = cellNumber(cells[at]);
      // Without a header or a second row the stamp may still be among them: it is the first, and no word.
      if (!range || std::isnan(*range) || (at == 0 && columns_.names.empty())) continue;
      ++numbers[at];
      below[at] += *range < 0.0 && *range != -1.0 ? 1 : 0;  // -1: no return
      largest = std::max(largest, *range);
      fractions |= *range != std::floor(*range);
      has_none_word |= *range == 8191.0;
    }
  });
  constexpr std::size_t kFewBelow = 10;  // one of so many
  for (const std::size_t at : columns_.ranges) {
    if (kFewBelow * below[at] <= numbers[at]) continue;
    throw std::runtime_error(in_.scans.string() + ": many of the numbers in column " + std::to_string(at + 1) +
                             " are below 0: they are no ranges of a lidar; name the first of these with --first-range");
  }
  std::string_view unit = in_.unit.empty() ? std::string_view(columns_.unit) : in_.unit;
  if (unit.empty()) {
    constexpr double kFarthest = 200.0, kLargestWord = 65535.0;
    if (largest <= kFarthest && (fractions || !columns_.names.empty())) {
      unit = "m";
    } else if (!fractions && largest <= kLargestWord && (largest > 8191.0 || has_none_word)) {
      unit = "words";
    } else {
      throw std::runtime_error(in_.scans.string() + ": ranges up to " + std::to_string(std::lround(largest)) +
                               " are no metres" + (fractions ? "" : ", without a single fraction") +
                               "; give their unit with --unit m, cm, mm or words (of a SICK)");
    }
  }
  words_ = unit == "words";
  metres_ = unit == "mm" ? 1e-3 : unit == "cm" ? 1e-2 : 1.0;
  if (words_ && !columns_.stamp) columns_.stamp = 0;  // such a table always has one
  std::erase(columns_.ranges, columns_.stamp.value_or(columns_.count));
  const std::string name = columns_.stamp && !columns_.names.empty() ? columns_.names[*columns_.stamp] : std::string();
  stamp_unit_ = columns_.stamp_in_ns ? 1e-3 : microsecondsPer(steps.empty() ? 0.0 : median(std::move(steps)), name);
  if (columns_.nanoseconds) stamp_unit_ = 1e6;
}

ScanTable::ScanTable(const CsvInput& in, Recording& recording)
    : in_(in), columns_(csvColumns(in.scans, in.stamp_column, in.first_range)) {
  findUnits();
  const std::size_t ranges = columns_.ranges.size();
  if (ranges < 2 || ranges > static_cast<std::size_t>(LaserScan::kCapacity)) {
    throw std::runtime_error(in.scans.string() + ": " + std::to_string(ranges) +
                             " columns of ranges; a scan has 2 to " + std::to_string(LaserScan::kCapacity));
  }
  constexpr std::size_t kFewestGuessed = 8;
  if (columns_.guessed && ranges < kFewestGuessed) {
    throw std::runtime_error(in.scans.string() + ": " + std::to_string(ranges) +
                             " columns of numbers without names are no ranges of scans; is each row of one beam? A "
                             "table of scans has a row for each scan; name the first range with --first-range");
  }
  bearings_ = bearingsOf(in, columns_, words_, recording);
}

class Csv : public Reader {
 public:
  explicit Csv(const CsvInput& in) : Reader(in.scans), input_(in) {}

  void read(Assembler& to) override {
    readSpeed(to);
    readEncoders(to);
    readImu(to);
    if (!in_.empty()) readScans(to);
  }

  void finish(Assembler& to) override {
    Recording& recording = to.recording;
    recording.format = "tables of numbers";
    if (!input_.encoders.empty()) {
      recording.robot.wheel_radius = input_.wheel_radius;
      recording.robot.half_track = input_.half_track;
    }
    if (!table_) return;
    if (recording.scans == 0) {
      throw std::runtime_error(in_.string() +
                               ": no row of it could be used as a scan; first refused: " + recording.first_rejection);
    }
    if (!table_->columns().stamp) {
      recording.notes.push_back(input_.period
                                    ? "the table has no stamps: --period was used"
                                    : "the table has no stamps: 0.1 s from scan to scan was taken; give --period");
    }
    recording.robot.range_min = table_->words() ? 0.1 : 0.05;
    recording.robot.range_max = table_->words() ? 50.0 : to.census.limit();
  }

 private:
  using Words = std::vector<std::string_view>;

  /// Calls row(words, origin) for each line with so many words or more, which says whether they are numbers; a header
  /// and comments are passed over.
  static void forEachRow(const std::filesystem::path& file, std::size_t columns, Assembler& to,
                         const std::function<bool(const Words&, const Origin&)>& row) {
    if (file.empty() || to.surveying()) return;
    const std::string name = file.filename().string();
    to.rows({.sensor = name});
    bool first = true;
    forEachLine(file, to, [&](const Words& words, Origin at) {
      if (words[0].front() == '#' || (std::exchange(first, false) && !toNumber(words[0]))) return;
      at.sensor = name;
      const auto time = toMicroseconds(words[0]);
      at.stamp = at.received = time.value_or(0) + kCsvEpoch;
      if (!time || words.size() < columns || !row(words, at)) to.refuse(at, "not a row of numbers");
    });
  }

  /// The speed is the mean since the row before it; there is no turn rate.
  void readSpeed(Assembler& to) const {
    Pose2 pose;
    std::optional<std::int64_t> previous;
    forEachRow(input_.speed, 2, to, [&](const Words& words, const Origin& at) {
      const auto speed = toNumber(words[1]);
      if (!speed) return false;
      if (previous) pose.x += *speed * static_cast<double>(at.stamp - *previous) * 1e-6;
      previous = at.stamp;
      to.wheels(at, pose, {}, false);
      return true;
    });
  }

  void readEncoders(Assembler& to) const {
    Pose2 pose;
    double angle_left = 0.0, angle_right = 0.0;
    forEachRow(input_.encoders, 5, to, [&](const Words& words, const Origin& at) {
      const auto ticks = toNumbers(words, 1);
      if (!ticks) return false;
      const double right = 0.5 * ((*ticks)[0] + (*ticks)[2]) * input_.metres_per_tick;
      const double left = 0.5 * ((*ticks)[1] + (*ticks)[3]) * input_.metres_per_tick;
      pose = pose * travelled(left, right, input_.half_track);
      angle_left += left / input_.wheel_radius;
      angle_right += right / input_.wheel_radius;
      to.wheels(at, pose, std::array{angle_left, angle_right});
      return true;
    });
  }

  void readImu(Assembler& to) const {
    forEachRow(input_.imu, 7, to, [&](const Words& words, const Origin& at) {
      const auto numbers = toNumbers({words.begin() + 1, words.begin() + 7});
      if (!numbers) return false;
      Eigen::Vector3d accel = kStandardGravity * Eigen::Vector3d(numbers->data()), gyro(numbers->data() + 3);
      gyro.z() *= input_.imu_sign_z;
      accel.z() *= input_.imu_sign_z;
      to.imu(at, gyro, accel);
      return true;
    });
  }

  void readScans(Assembler& to) {
    if (!table_) table_.emplace(input_, to.recording);
    table_->rewind();
    const std::string name = in_.filename().string();
    if (!to.surveying()) to.rows({.sensor = name});
    const CsvColumns& columns = table_->columns();
    const int damage = forEachCsvRow(in_, columns, [&](const auto& cells, int line) {
      Origin at{.sensor = name, .where = name + ":" + std::to_string(line)};
      if (const char* wrong = table_->read(cells, at, *scan_)) return to.refuse(at, wrong);
      if (columns.x && columns.y && columns.theta) {
        const Origin odometry = at.of(name + " (x, y, theta)");
        const auto pose = table_->pose(cells);
        pose ? to.wheels(odometry, *pose) : to.refuse(odometry, "x, y or theta is not a number");
      }
      to.scan(at, *scan_, {.written = table_->written()});
    });
    if (damage > 0) to.refuse({.sensor = {}, .where = name + ":" + std::to_string(damage)}, kDamage);
  }

  const CsvInput& input_;
  std::optional<ScanTable> table_;
};

}  // namespace

Recording convertCsv(const CsvInput& in, const std::filesystem::path& out) { return assemble(Csv(in), out); }

}  // namespace slam
