// SPDX-License-Identifier: BSD-3-Clause
#include "tools/convert/csv_table.hpp"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <limits>
#include <map>
#include <numbers>
#include <stdexcept>

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
};
std::optional<RangeName> rangeName(std::string name) {
  if (const auto number = toNumber(name)) return RangeName{*number, true};
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
    return RangeName{*number, false};
  }
  return std::nullopt;
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

void useHeader(CsvColumns& columns) {
  std::vector<RangeName> ranges;
  for (std::size_t i = 0; i < columns.names.size(); ++i) {
    const std::string& name = columns.names[i];
    const auto role = [&](std::optional<std::size_t>& to) {
      if (!to) to = i;
    };
    if (isOneOf(name, {"x", "odom_x", "pose_x", "x_m", "robot_x"}))
      role(columns.x);
    else if (isOneOf(name, {"y", "odom_y", "pose_y", "y_m", "robot_y"}))
      role(columns.y);
    else if (isOneOf(name,
                     {"theta", "yaw", "heading", "odom_theta", "odom_yaw", "pose_theta", "theta_rad", "robot_theta"}))
      role(columns.theta);
    else if (name == "angle_min")
      role(columns.angle_min);
    else if (name == "angle_max")
      role(columns.angle_max);
    else if (isOneOf(name, {"angle_increment", "angle_step"}))
      role(columns.angle_increment);
    else if (const auto range = rangeName(name)) {
      columns.ranges.push_back(i);
      ranges.push_back(*range);
    } else if (isStampName(name)) {
      role(columns.stamp);
    }
  }
  const auto is = [&](auto test) { return !ranges.empty() && std::all_of(ranges.begin(), ranges.end(), test); };
  const bool named = is([](const RangeName& r) { return r.is_bearing; });
  const bool below = std::any_of(ranges.begin(), ranges.end(), [](const RangeName& r) { return r.number < 0.0; });
  const bool whole = is([](const RangeName& r) { return r.number == std::floor(r.number); });
  // 0, 1, 2, ... count the columns; -90, -89, ... cannot.
  bool counts = !below && whole;
  for (std::size_t i = 1; i < ranges.size(); ++i) counts &= ranges[i].number == ranges[i - 1].number + 1.0;
  if (counts && !(named && ranges.size() == 360)) return;
  if (!named && !below && whole) return;
  const bool radians =
      !whole && is([](const RangeName& r) { return std::abs(r.number) <= 2.0 * std::numbers::pi + 1e-3; });
  for (const RangeName& range : ranges) {
    columns.bearings.push_back(radians ? range.number : range.number * std::numbers::pi / 180.0);
  }
}

}  // namespace

char separatorOf(std::string_view line) {
  for (const char c : {',', ';', '\t'}) {
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
  if (!cell.empty() && cell.front() == '+') return toNumber(cell.substr(1));
  const std::string word = lower(cell);
  const bool none =
      isOneOf(word, {"", "nan", "-nan", "inf", "-inf", "+inf", "infinity", "none", "null", "na", "n/a", "-"});
  return none ? std::optional(kNone) : std::nullopt;
}

CsvColumns csvColumns(const std::filesystem::path& file, const std::string& stamp_column,
                      const std::string& first_range) {
  constexpr int kRows = 2000;
  constexpr double kLike = 0.1;  // [1] two beams side by side mostly differ by less
  CsvColumns columns;
  std::vector<std::string> header;
  std::map<std::size_t, int> counts;
  bool rising = true;
  double first = kNone, last = kNone;
  int rows = 0, like_second = 0;
  bool begun = false;
  TextFile text(file);
  for (std::string line; rows < kRows && text.next(line);) {
    std::string_view rest = trimmed(line);
    const bool comment = rest.starts_with("#");
    while (rest.starts_with("#")) rest = trimmed(rest.substr(1));
    if (rest.empty() || (comment && begun)) continue;
    const char separator = separatorOf(rest);
    const auto cells = splitCells(rest, separator);
    const auto numbers =
        std::count_if(cells.begin(), cells.end(), [](auto cell) { return toNumber(cell).has_value(); });
    const bool first_word = !cells.empty() && !cellNumber(cells[0]);
    if (comment || (!begun && (2 * numbers < static_cast<std::ptrdiff_t>(cells.size()) || first_word))) {
      header.clear();
      for (const auto cell : cells) header.push_back(lower(cell));
      begun = begun || !comment;
      continue;
    }
    begun = true;
    columns.separator = separator;
    ++counts[cells.size()];
    ++rows;
    const auto value = cellNumber(cells[0]);
    if (!value || !(*value >= (std::isnan(last) ? *value : last))) rising = false;
    if (std::isnan(first)) first = value.value_or(kNone);
    last = value.value_or(kNone);
    const auto second = cells.size() > 1 ? cellNumber(cells[1]) : std::nullopt;
    if (value && second && std::abs(*value - *second) <= kLike * std::abs(*second)) ++like_second;
  }
  for (const auto& [count, times] : counts) {
    if (columns.count == 0 || times > counts[columns.count]) columns.count = count;
  }
  if (columns.count == 0) throw std::runtime_error(file.string() + ": no row of numbers in it");
  if (header.size() == columns.count) columns.names = header;
  useHeader(columns);
  if (!stamp_column.empty()) columns.stamp = columnOf(columns, stamp_column, file);
  // A range that happens to rise from row to row is still like the one beside it.
  const bool stamps = rising && rows > 1 && last > first && 2 * like_second < rows;
  if (columns.names.empty() && stamp_column.empty() && stamps) columns.stamp = 0;
  const bool named = !columns.ranges.empty();
  if (!first_range.empty() || !named) {
    columns.ranges.clear();
    columns.bearings.clear();
    const std::size_t begin = first_range.empty() ? 0 : columnOf(columns, first_range, file);
    for (std::size_t i = begin; i < columns.count; ++i) {
      const bool other = i == columns.stamp || i == columns.x || i == columns.y || i == columns.theta ||
                         i == columns.angle_min || i == columns.angle_max || i == columns.angle_increment;
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

void forEachCsvRow(const std::filesystem::path& file, const CsvColumns& columns,
                   const std::function<void(const std::vector<std::string_view>&, int)>& row) {
  TextFile text(file);
  bool header = !columns.names.empty();
  for (std::string line; text.next(line);) {
    const std::string_view rest = trimmed(line);
    if (rest.empty() || rest.starts_with("#")) continue;
    const auto cells = splitCells(line, columns.separator);
    const bool names = header && !cellNumber(cells[0]);
    header = false;
    if (!names) row(cells, text.lineNumber());
  }
}

}  // namespace slam
