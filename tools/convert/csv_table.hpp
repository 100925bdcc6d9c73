// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace slam {

/// What the columns of a table of scans are.
struct CsvColumns {
  std::vector<std::string> names;  ///< of the header; empty: it has none
  bool header_row = false;         ///< the first row is that header, or holds the bearings
  std::size_t count = 0;           ///< columns of a usual row
  char separator = ',';            ///< ' ': blanks
  std::optional<std::size_t> stamp, x, y, theta, angle_min, angle_max, angle_increment, time_increment, range_max;
  std::optional<std::size_t> nanoseconds;  ///< that go with whole seconds of the stamp
  bool stamp_in_ns = false;                ///< as rostopic writes them
  std::vector<std::size_t> ranges;
  std::string unit;              ///< of the ranges, as the header names it: "m", "cm", "mm"; empty: it does not
  std::vector<double> bearings;  ///< [rad] as the header names them; empty: it does not
  bool guessed = false;          ///< neither a header nor an option says which columns hold the ranges
};

/// What parts a line into cells: the first of semicolon, tab and comma that is in it, else blanks (' '). Where it is
/// not the comma, a comma may stand in numbers, before their decimals.
char separatorOf(std::string_view line);

/// Words between separators, empty ones too.
std::vector<std::string_view> splitCells(std::string_view line, char separator);

/// A number, also with a comma before its decimals or a bracket around it; a cell that says "none" is NaN. nullopt:
/// neither.
std::optional<double> cellNumber(std::string_view cell);

/// Finds out by the header and the first rows what is where.
/// @param stamp_column, first_range name or number from 1; empty: to be found
/// @throws std::runtime_error when a column is not there, no column holds ranges, or a row is no scan
CsvColumns csvColumns(const std::filesystem::path& file, const std::string& stamp_column,
                      const std::string& first_range);

/// Calls row(cells, line number) for each line that is neither header nor comment.
/// @return where compressed data is damaged, as a line's number; 0: nowhere
int forEachCsvRow(const std::filesystem::path& file, const CsvColumns& columns,
                  const std::function<void(const std::vector<std::string_view>&, int)>& row);

}  // namespace slam
