// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cctype>
#include <map>
#include <memory>
#include <stdexcept>
#include <string>
#include <zlib.h>

#include "tools/convert/bags/ros_source.hpp"
#include "tools/convert/csv_table.hpp"
#include "tools/convert/formats.hpp"
#include "tools/convert/text_file.hpp"

namespace slam {
namespace {

/// The first bytes of a file, unpacked where it is compressed by gzip.
std::string beginning(const std::filesystem::path& file) {
  const std::unique_ptr<gzFile_s, decltype(&gzclose)> in(gzopen(file.c_str(), "rb"), &gzclose);
  if (!in) throw std::runtime_error(file.string() + ": cannot open");
  std::string bytes(1 << 16, '\0');
  const int got = gzread(in.get(), bytes.data(), static_cast<unsigned>(bytes.size()));
  bytes.resize(got > 0 ? static_cast<std::size_t>(got) : 0);
  return bytes;
}

enum class Text { kNone, kCarmen, kWean, kMines, kTable };

/// What the lines of a text are, by the first of them that say it.
Text kindOfText(const std::filesystem::path& file) {
  constexpr int kLines = 2000, kEnough = 3;
  constexpr std::size_t kBytes = std::size_t{16} << 20;
  constexpr std::size_t kMinesColumns = 706, kWeanLaser = 188;  // at least, exactly
  std::map<Text, int> votes;
  int lines = 0;
  TextFile text(file);
  std::string line;
  std::size_t bytes = 0;
  for (int i = 0; i < kLines && bytes < kBytes && text.next(line); ++i) {
    bytes += line.size();
    const auto words = splitWords(line);
    if (words.empty() || words[0].front() == '#') continue;
    ++lines;
    const std::string_view first = words[0];
    if (first == "FLASER" || first == "ODOM" || first == "PARAM" || first.starts_with("ROBOTLASER"))
      return Text::kCarmen;
    if ((first == "L" && words.size() == kWeanLaser) || (first == "O" && words.size() == 5)) {
      if (++votes[Text::kWean] >= kEnough) return Text::kWean;
    } else if (words.size() >= kMinesColumns && line.find(',') == std::string::npos && toNumbers(words)) {
      if (++votes[Text::kMines] >= kEnough) return Text::kMines;
    } else {
      const auto cells = splitCells(line, separatorOf(line));
      const auto numbers =
          std::count_if(cells.begin(), cells.end(), [](std::string_view cell) { return cellNumber(cell).has_value(); });
      // Lines that begin with a word are of a log; a date begins with a digit.
      const bool row = cellNumber(cells[0]) || std::isdigit(static_cast<unsigned char>(cells[0].front())) != 0;
      if (row && cells.size() >= 3 && 10 * numbers >= 8 * static_cast<std::ptrdiff_t>(cells.size()))
        ++votes[Text::kTable];
    }
  }
  return votes[Text::kTable] > 0 && 2 * votes[Text::kTable] >= lines ? Text::kTable : Text::kNone;
}

}  // namespace

Recording convertAny(const std::filesystem::path& in, const std::filesystem::path& out) {
  if (std::filesystem::is_directory(in)) return convertRos(in, out);
  const std::string begin = beginning(in);
  if (openRosFile(in) != nullptr) return convertRos(in, out);
  if (begin.starts_with("\xED\xA1\xDA\x01")) return isMbotLog(in) ? convertMbot(in, out) : convertLcm(in, out);
  if (begin.starts_with("#ROSBAG V1")) {
    throw std::runtime_error(in.string() + ": a bag of version 1; bring it to 2.0 with  rosbag fix  first");
  }
  if (begin.starts_with("\x28\xB5\x2F\xFD")) {
    throw std::runtime_error(in.string() + ": packed by zstd; unpack it first with  zstd -d");
  }
  switch (begin.empty() ? Text::kNone : kindOfText(in)) {
    case Text::kCarmen:
      return convertCarmen(in, out);
    case Text::kWean:
      return convertWean(in, out);
    case Text::kMines:
      return convertMines(in, out);
    case Text::kTable:
      return convertCsv({.scans = in}, out);
    case Text::kNone:
      break;
  }
  throw std::runtime_error(in.string() +
                           ": not recognised; nothing was written. Read are CARMEN logs (lines FLASER, ROBOTLASER1, "
                           "ODOM), bags of ROS 1 (.bag) and ROS 2 (.db3, .mcap, a folder of them), LCM logs of slamd, "
                           "MBot and Maebot, the logs of Wean Hall and Mines, and tables with a row of ranges for each "
                           "scan (csv)");
}

}  // namespace slam
