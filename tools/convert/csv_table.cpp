// SPDX-License-Identifier: BSD-3-Clause
#include "tools/convert/csv_table.hpp"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <limits>
#include <map>
#include <numbers>
#include <stdexcept>
#include <utility>

#include "tools/convert/text_file.hpp"

namespace slam {
namespace {

constexpr double kNone = std::numeric_limits<double>::quiet_NaN();

std::string_view trimmed(std::string_view text) {
  constexpr std::string_view kBlanks = " \t\"'";
  const std::size_t begin = text.find_first_not_of(kBlanks);
  return begin == std::string_view::npos ? std::string_view()
                                         : text.substr(begin, text.find_last_not_of(kBlanks) - begin + 1);
}

std::string lower(std::string_view text) {
  std::string word(text);
  std::transform(word.begin(), word.end(), word.begin(), [](unsigned char c) { return std::tolower(c); });
  return word;
}

bool isStampName(const std::string& name) {
  return name == "t" || name == "sec" || name == "secs" || name == "seconds" || name.starts_with("t_") ||
         name.starts_with("t[") || name.find("time") != std::string::npos || name.find("stamp") != std::string::npos;
}

bool isOneOf(const std::string& name, std::initializer_list<const char*> names) {
  return std::any_of(names.begin(), names.end(), [&](const char* other) { return name == other; });
}

/// The number that a range's column is named by: an index or a bearing; nullopt: not a range.
struct RangeName {
  double number;
  bool is_bearing;  // else an index, unless the numbers show that they are none
  std::string unit = {};
};
std::optional<RangeName> rangeName(std::string name) {
  if (const auto number = toNumber(name)) return RangeName{*number, true};
  std::string unit;
  for (const char* const word : {"mm", "cm", "m"}) {
    for (const auto& [before, behind] : {std::pair("[", "]"), std::pair("(", ")"), std::pair("_", "")}) {
      const std::string ending = std::string(before) + word + behind;
      if (!unit.empty() || !name.ends_with(ending)) continue;
      unit = word;
      name.resize(name.find_last_not_of(' ', name.size() - ending.size() - 1) + 1);
    }
  }
  if (!name.empty() && (name.back() == ']' || name.back() == ')')) name.pop_back();
  const std::size_t digits = name.find_first_of("0123456789");
  if (digits == std::string::npos) return std::nullopt;
  std::size_t begin = digits;
  if (begin > 1 && name[begin - 1] == '-') --begin;
  const auto number = toNumber(std::string_view(name).substr(begin));
  std::string word = name.substr(0, begin);
  while (!word.empty() && std::string_view("_[(. ").find(word.back()) != std::string_view::npos) word.pop_back();
  if (!number) return std::nullopt;
  if (isOneOf(word, {"angle", "deg", "bearing", "a"})) return RangeName{*number, true};
  if (isOneOf(word, {"r", "range", "ranges", "d", "dist", "distance", "distances", "beam", "scan", "b", "laser"})) {
    return RangeName{*number, false, unit};
  }
  return std::nullopt;
}

/// A name without the path that leads to it ("field.header.stamp", "/scan/ranges[0]", "%time").
std::string lastPart(std::string name) {
  if (name.starts_with("%")) name.erase(0, 1);
  if (name.starts_with("/")) name.erase(0, name.find_last_of('/') + 1);
  const std::size_t at = name.find_last_of('.');
  const bool letter =
      at != std::string::npos && at + 1 < name.size() && std::isalpha(static_cast<unsigned char>(name[at + 1])) != 0;
  return letter ? name.substr(at + 1) : name;
}

/// Equal steps through an angle that a lidar may see. Ranges of a scan are never that.
bool areBearings(const std::vector<double>& values) {
  constexpr std::size_t kFewest = 8;
  constexpr double kNarrowest = 0.5, kTurn = 360.0;  // [rad, deg]
  if (values.size() < kFewest) return false;
  const double span = values.back() - values.front(), step = span / static_cast<double>(values.size() - 1);
  if (!(std::abs(span) >= kNarrowest) || std::abs(span) > kTurn + 0.5 * std::abs(step)) return false;
  for (std::size_t i = 0; i < values.size(); ++i) {
    const bool even = std::abs(values[i] - values.front() - step * static_cast<double>(i)) <= 0.5 * std::abs(step);
    const bool on = i == 0 || (values[i] - values[i - 1]) * step > 0.0;
    if (!even || !on || std::abs(values[i]) > kTurn) return false;
  }
  return true;
}

bool namesBearings(const std::string& name) {
  return isOneOf(name, {"angle", "angles", "angle_deg", "angle_rad", "bearing", "bearings", "azimuth"});
}

std::size_t columnOf(const CsvColumns& columns, const std::string& asked, const std::filesystem::path& file) {
  const auto at = std::find(columns.names.begin(), columns.names.end(), lower(asked));
  if (at != columns.names.end()) return static_cast<std::size_t>(at - columns.names.begin());
  const auto number = toNumber(asked);
  if (!number || !(*number >= 1.0) || *number > static_cast<double>(columns.count) || *number != std::floor(*number)) {
    throw std::runtime_error(file.string() + ": no column " + asked + "; it has " + std::to_string(columns.count));
  }
  return static_cast<std::size_t>(*number) - 1;
}

/// Columns that a name alone decides.
struct Role {
  std::optional<std::size_t> CsvColumns::*column;
  std::vector<std::string_view> names;
};
const Role kRoles[] = {
    {&CsvColumns::x, {"x", "odom_x", "pose_x", "x_m", "robot_x"}},
    {&CsvColumns::y, {"y", "odom_y", "pose_y", "y_m", "robot_y"}},
    {&CsvColumns::theta,
     {"theta", "yaw", "heading", "odom_theta", "odom_yaw", "pose_theta", "theta_rad", "robot_theta"}},
    {&CsvColumns::angle_min, {"angle_min"}},
    {&CsvColumns::angle_max, {"angle_max"}},
    {&CsvColumns::angle_increment, {"angle_increment", "angle_step"}},
    {&CsvColumns::time_increment, {"time_increment"}},
    {&CsvColumns::range_max, {"range_max"}},
    {&CsvColumns::nanoseconds, {"nsec", "nsecs", "nanosec", "nanosecs", "stamp_nsec", "stamp_nanosec"}},
};

void useHeader(CsvColumns& columns, const std::filesystem::path& file) {
  std::vector<RangeName> ranges;
  std::optional<std::size_t> bearing_column;
  for (std::size_t i = 0; i < columns.names.size(); ++i) {
    columns.stamp_in_ns |= columns.names[i] == "%time" || columns.names[i].starts_with("field.");
    const std::string name = lastPart(columns.names[i]);
    const auto* const role = std::find_if(std::begin(kRoles), std::end(kRoles),
                                          [&](const Role& one) { return std::ranges::count(one.names, name) > 0; });
    if (role != std::end(kRoles)) {
      auto& column = columns.*role->column;
      if (!column) column = i;
    } else if (namesBearings(name)) {
      bearing_column = i;
    } else if (const auto range = rangeName(name)) {
      columns.ranges.push_back(i);
      ranges.push_back(*range);
      if (!range->unit.empty()) columns.unit = range->unit;
    } else if (isStampName(name) && name != "scan_time") {
      if (!columns.stamp) columns.stamp = i;
    }
  }
  const bool whole_seconds =
      columns.stamp && isOneOf(lastPart(columns.names[*columns.stamp]), {"sec", "secs", "stamp_sec"});
  if (!whole_seconds) columns.nanoseconds.reset();
  const auto is = [&](auto test) { return !ranges.empty() && std::all_of(ranges.begin(), ranges.end(), test); };
  const bool named = is([](const RangeName& r) { return r.is_bearing; });
  if (bearing_column && !named) {
    throw std::runtime_error(file.string() + ": each row is of one bearing, that of column " +
                             columns.names[*bearing_column] + "; a table of scans has a row for each scan");
  }
  const bool below = std::any_of(ranges.begin(), ranges.end(), [](const RangeName& r) { return r.number < 0.0; });
  const bool whole = is([](const RangeName& r) { return r.number == std::floor(r.number); });
  // 0, 1, 2, ... count the columns; -90, -89, ... cannot.
  bool counts = !below && whole;
  int rising = 0, falling = 0;
  for (std::size_t i = 1; i < ranges.size(); ++i) {
    counts &= ranges[i].number == ranges[i - 1].number + 1.0;
    ++(ranges[i].number > ranges[i - 1].number ? rising : falling);
  }
  if (counts && !(named && ranges.size() == 360)) return;
  if (!named && !below && whole) return;
  if (std::min(rising, falling) > 1) {  // one may be where a turn begins anew
    throw std::runtime_error(file.string() +
                             ": its first line is no header, for the numbers in it are no bearings, and no row of "
                             "numbers, for it begins with a word; give each row's time in seconds");
  }
  const bool radians =
      !whole && is([](const RangeName& r) { return std::abs(r.number) <= 2.0 * std::numbers::pi + 1e-3; });
  for (const RangeName& range : ranges) {
    columns.bearings.push_back(radians ? range.number : range.number * std::numbers::pi / 180.0);
  }
}

/// Whether a column may hold the time of each row, by all rows.
class TimeColumn {
 public:
  void add(std::optional<double> value, std::optional<double> beside) {
    constexpr double kLike = 0.1;  // [1] two beams side by side mostly differ by less
    const double now = value.value_or(kNone);
    if (rows_ == 0 && std::isnan(now)) return;  // the corner of a table may be empty
    ++rows_;
    if (rows_ == 1) first_ = now;
    falls_ |= !(now >= (rows_ == 1 ? now : last_));
    stays_ |= rows_ > 1 && !(now > last_);
    counts_ &= rows_ == 1 || now == last_ + 1.0;
    // A range that happens to rise from row to row is still like the one beside it.
    if (value && beside && std::abs(*value - *beside) <= kLike * std::abs(*beside)) ++like_;
    last_ = now;
  }
  bool rises() const { return !falls_ && rows_ > 1 && last_ > first_ && 2 * like_ < rows_; }
  /// Not by chance.
  bool surelyRises() const { return rises() && !stays_ && rows_ >= 8; }
  bool counts() const { return counts_; }
  /// From 0 or 1 on: of the rows, not of seconds.
  bool countsRows() const { return counts_ && rows_ > 2 && (first_ == 0.0 || first_ == 1.0); }

 private:
  int rows_ = 0, like_ = 0;
  bool falls_ = false, stays_ = false, counts_ = true;
  double first_ = kNone, last_ = kNone;
};

/// What the first rows of a table show.
struct Shape {
  std::vector<double> first_row, second_row, last_row, first_column;
  TimeColumn first, second, last;
  int rows = 0;

  void add(const std::vector<std::string_view>& cells) {
    const auto number = [&](std::size_t i) { return i < cells.size() ? cellNumber(cells[i]) : std::nullopt; };
    const std::size_t n = cells.size();
    last_row.clear();
    for (std::size_t i = 0; i < n; ++i) last_row.push_back(number(i).value_or(kNone));
    if (rows == 0) first_row = last_row;
    if (rows == 1) second_row = last_row;
    first_column.push_back(number(0).value_or(kNone));
    first.add(number(0), number(1));
    second.add(number(1), number(2));
    last.add(number(n - 1), n > 1 ? number(n - 2) : std::nullopt);
    ++rows;
  }
  /// Its column holds times, which move on.
  bool moves(std::size_t column) const {
    if (column >= first_row.size() || column >= last_row.size()) return false;
    return first_row[column] > 0.0 && (rows == 1 || last_row[column] > first_row[column]);
  }
  /// The first row holds bearings, from this column on. nullopt: it does not
  std::optional<std::size_t> bearingsFrom() const {
    for (const std::size_t from : {0U, 1U}) {
      const auto part = [&](const std::vector<double>& row) {
        return std::vector<double>(row.begin() + static_cast<std::ptrdiff_t>(std::min(from, row.size())), row.end());
      };
      if (areBearings(part(first_row)) && rows > 1 && !areBearings(part(second_row))) return from;
    }
    return std::nullopt;
  }
  /// The first column holds bearings: the table stands on its side. Those of a whole turn may as well be times.
  bool onItsSide(bool or_times) const {
    for (const std::ptrdiff_t from : {0, 1}) {  // the corner may be anything
      if (first_column.size() <= static_cast<std::size_t>(from)) return false;
      const std::vector<double> column(first_column.begin() + from, first_column.end());
      const double step = (column.back() - column.front()) / static_cast<double>(column.size());
      const double rest = std::abs(column.back() - column.front() + step);
      const bool turn = std::abs(rest - 360.0) < 1.0 || std::abs(rest - 2.0 * std::numbers::pi) < 0.02;
      if (areBearings(column) && (column.front() < 0.0 || column.back() < 0.0 || (turn && !or_times))) return true;
    }
    return false;
  }
};

/// ros2 topic echo --csv: a LaserScan's fields without a header. Empty: it is none.
std::vector<std::string> fieldsOfRos2(const std::vector<std::string_view>& cells) {
  std::vector<std::string> names = {"sec",       "nanosec",         "frame_id",       "angle_min",
                                    "angle_max", "angle_increment", "time_increment", "scan_time",
                                    "range_min", "range_max"};
  if (cells.size() < names.size() + 2 || cellNumber(cells[2])) return {};
  const auto nanoseconds = toNumber(cells[1]), least = toNumber(cells[3]), most = toNumber(cells[4]),
             step = toNumber(cells[5]);
  if (!nanoseconds || !(*nanoseconds >= 0.0 && *nanoseconds < 1e9) || !least || !most || !step) return {};
  const std::size_t left = cells.size() - names.size();
  const double beams = std::round((*most - *least) / *step) + 1.0;
  // Of so many numbers, all are ranges, or one half are intensities.
  const bool halves = left % 2 == 0 && std::abs(beams - static_cast<double>(left / 2)) <= 1.0;
  if (!halves && !(std::abs(beams - static_cast<double>(left)) <= 1.0)) return {};
  for (std::size_t i = 0; i < left; ++i)
    names.push_back((halves && i >= left / 2 ? "intensities" : "ranges") + std::to_string(i));
  return names;
}

/// The first rows of a table.
struct Sample {
  std::vector<std::string> header;
  std::map<std::size_t, int> counts;  // rows by their number of cells
  Shape shape;
};

Sample sampleOf(const std::filesystem::path& file, CsvColumns& columns) {
  constexpr int kRows = 2000;
  Sample sample;
  bool begun = false;
  TextFile text(file);
  for (std::string line; sample.shape.rows < kRows && text.next(line);) {
    std::string_view rest = trimmed(line);
    const bool comment = rest.starts_with("#");
    while (rest.starts_with("#")) rest = trimmed(rest.substr(1));
    if (rest.empty() || (comment && begun)) continue;
    const char separator = separatorOf(rest);
    const auto cells = splitCells(rest, separator);
    const auto numbers =
        std::count_if(cells.begin(), cells.end(), [](auto cell) { return cellNumber(cell).has_value(); });
    const bool first_word = !cells.empty() && !cellNumber(cells[0]);
    if (comment || (!begun && (2 * numbers < static_cast<std::ptrdiff_t>(cells.size()) || first_word))) {
      sample.header.clear();
      for (const auto cell : cells) sample.header.push_back(lower(cell));
      columns.header_row = !comment;
      begun = begun || !comment;
      continue;
    }
    begun = true;
    columns.separator = separator;
    if (sample.shape.rows == 0 && sample.header.empty()) sample.header = fieldsOfRos2(cells);
    ++sample.counts[cells.size()];
    sample.shape.add(cells);
  }
  for (const auto& [count, times] : sample.counts) {
    if (columns.count == 0 || times > sample.counts[columns.count]) columns.count = count;
  }
  if (columns.count == 0) throw std::runtime_error(file.string() + ": no row of numbers in it");
  return sample;
}

/// Names the columns by the header, or by a first row of bearings.
/// @param bare nothing names a column
void nameColumns(CsvColumns& columns, const Sample& sample, bool bare, const std::filesystem::path& file) {
  const auto& [header, counts, shape] = sample;
  if (header.size() == columns.count) columns.names = header;
  const auto bearings = bare && shape.first_row.size() == columns.count ? shape.bearingsFrom() : std::nullopt;
  if (bearings) {
    columns.header_row = true;
    for (std::size_t i = 0; i < columns.count; ++i)
      columns.names.push_back(i < *bearings ? "" : std::to_string(shape.first_row[i]));
  }
  const bool labelled = !header.empty() && (header.front().empty() || namesBearings(header.front()));
  if ((bare || labelled) && shape.onItsSide(bearings || labelled)) {
    throw std::runtime_error(file.string() +
                             ": it stands on its side: its first column holds the bearings, and a table of scans has a "
                             "row for each scan; turn it");
  }
  useHeader(columns, file);
}

/// Finds the column of the stamps by what its numbers do, where no name gives it.
/// @return the column that numbers the rows, if there is one
std::optional<std::size_t> findStamp(CsvColumns& columns, const Shape& shape) {
  const bool first_is_range = !columns.ranges.empty() && columns.ranges.front() == 0;
  const bool nameless = columns.names.empty() || columns.names.front().empty() || !columns.bearings.empty();
  std::optional<std::size_t> counter;
  if (columns.stamp || !nameless || first_is_range) return counter;
  if (shape.first.rises()) (shape.first.countsRows() ? counter : columns.stamp) = 0;
  if (columns.names.empty() && shape.first.rises() && shape.second.surelyRises()) {
    counter = shape.first.counts() ? 0 : 1;
    columns.stamp = 1 - *counter;
  }
  if (columns.names.empty() && !columns.stamp && shape.last.surelyRises()) columns.stamp = columns.count - 1;
  return counter;
}

}  // namespace

char separatorOf(std::string_view line) {
  for (const char c : {';', '\t', ','}) {
    if (line.find(c) != std::string_view::npos) return c;
  }
  return ' ';
}

std::vector<std::string_view> splitCells(std::string_view line, char separator) {
  if (separator == ' ') return splitWords(line);
  std::vector<std::string_view> cells;
  for (std::size_t begin = 0;;) {
    const std::size_t end = std::min(line.find(separator, begin), line.size());
    cells.push_back(trimmed(line.substr(begin, end - begin)));
    if (end == line.size()) break;
    begin = end + 1;
  }
  if (cells.size() > 1 && cells.back().empty()) cells.pop_back();  // a separator at the end of each line
  return cells;
}

std::optional<double> cellNumber(std::string_view cell) {
  if (const auto number = toNumber(cell)) return number;
  constexpr std::string_view kAround = "[](){} \"'";  // lists that were written as text
  cell.remove_prefix(std::min(cell.find_first_not_of(kAround), cell.size()));
  cell = cell.substr(0, cell.find_last_not_of(kAround) + 1);
  if (!cell.empty() && cell.front() == '+') cell.remove_prefix(1);
  if (const auto number = toNumber(cell)) return number;
  if (const std::size_t comma = cell.find(','); comma != std::string_view::npos) {
    std::string point(cell);
    point[comma] = '.';
    return toNumber(point);
  }
  const std::string word = lower(cell);
  const bool none =
      isOneOf(word, {"", "nan", "-nan", "inf", "-inf", "+inf", "infinity", "none", "null", "na", "n/a", "-"});
  return none ? std::optional(kNone) : std::nullopt;
}

CsvColumns csvColumns(const std::filesystem::path& file, const std::string& stamp_column,
                      const std::string& first_range) {
  CsvColumns columns;
  const Sample sample = sampleOf(file, columns);
  nameColumns(columns, sample, sample.header.empty() && stamp_column.empty() && first_range.empty(), file);
  for (std::size_t i = 0; i < columns.names.size(); ++i) {  // when it was measured rather than when it was recorded
    if (columns.names[i].ends_with("header.stamp") && sample.shape.moves(i)) columns.stamp = i;
  }
  if (!stamp_column.empty()) columns.stamp = columnOf(columns, stamp_column, file);
  const bool named = !columns.ranges.empty();
  const std::optional<std::size_t> counter = findStamp(columns, sample.shape);
  columns.guessed = first_range.empty() && !named;
  if (!first_range.empty() || !named) {
    columns.ranges.clear();
    columns.bearings.clear();
    const std::size_t begin = first_range.empty() ? 0 : columnOf(columns, first_range, file);
    for (std::size_t i = begin; i < columns.count; ++i) {
      const auto is = [&](const Role& role) { return columns.*role.column == i; };
      const bool other = i == columns.stamp || i == counter || std::any_of(std::begin(kRoles), std::end(kRoles), is);
      if (!other) columns.ranges.push_back(i);
    }
  }
  // Names that are no ranges' belong to another table, unless it is so wide that hardly anything else is meant.
  constexpr std::size_t kWide = 30;
  const bool found = !first_range.empty() || named || columns.names.empty() || columns.ranges.size() >= kWide;
  if (columns.ranges.size() < 2 || !found) {
    throw std::runtime_error(file.string() + ": no columns of ranges found; name the first with --first-range");
  }
  return columns;
}

int forEachCsvRow(const std::filesystem::path& file, const CsvColumns& columns,
                  const std::function<void(const std::vector<std::string_view>&, int)>& row) {
  TextFile text(file);
  bool header = columns.header_row;
  for (std::string line; text.next(line);) {
    const std::string_view rest = trimmed(line);
    if (rest.empty() || rest.starts_with("#")) continue;
    if (!std::exchange(header, false)) row(splitCells(line, columns.separator), text.lineNumber());
  }
  return text.damaged() ? text.lineNumber() : 0;
}

}  // namespace slam
