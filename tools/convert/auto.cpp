// SPDX-License-Identifier: BSD-3-Clause
#include "tools/convert/auto.hpp"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <map>
#include <memory>
#include <slam/config_t.hpp>
#include <stdexcept>
#include <string>
#include <zlib.h>

#include "bus/channels.hpp"
#include "bus/checked_decode.hpp"
#include "bus/event_log.hpp"
#include "bus/received.hpp"
#include "tools/convert/bags/ros.hpp"
#include "tools/convert/bags/ros_source.hpp"
#include "tools/convert/beam_times.hpp"
#include "tools/convert/carmen.hpp"
#include "tools/convert/csv.hpp"
#include "tools/convert/csv_table.hpp"
#include "tools/convert/formats.hpp"
#include "tools/convert/log_output.hpp"
#include "tools/convert/mbot.hpp"
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

bool isMbotLog(const std::filesystem::path& file) {
  EventLogReader log(file);
  for (LogEvent event; log.next(event);) {
    std::uint64_t type = 0;
    for (std::size_t i = 0; i < 8 && i < event.data.size(); ++i) type = type << 8 | event.data[i];
    if (type == kMbotLidar) return true;
    if (event.channel == channel::kScan) return false;
  }
  return false;
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

/// slamd's own messages go as they are, but for those that are no measurement.
template <typename Message>
Refusal copy(const LogEvent& event, const char* channel, LogOutput& log, std::int64_t& utime) {
  const Received<Message> received(event.data);
  if (!received) return received.refusal;
  utime = received.message->utime;
  log.add(event.utime, channel, event.data);
  return Refusal::kNone;
}

/// [us] from a scan's stamp to its last beam
std::int64_t span(const LaserScan& scan) {
  float longest = 0.0F;
  for (const Beam& beam : scan.beams()) longest = std::max(longest, beam.time_offset);
  return std::llround(1e6 * static_cast<double>(longest));
}
/// Where all are 0, nobody says when the beams were measured.
bool hasTimes(const LaserScan& scan) { return span(scan) > 0; }

/// @param copied_turn [us] over which scans with beam times were measured before these; nullopt: they are right
Refusal copyScan(const LogEvent& event, std::optional<std::int64_t> copied_turn, LogOutput& log, std::int64_t& utime) {
  Received<scan_t> scan(event.data);
  if (!copied_turn || !scan || !hasTimes(*scan.sample)) return copy<scan_t>(event, channel::kScan, log, utime);
  utime = scan.message->utime - *copied_turn;
  for (int i = 0; i < scan.sample->size; ++i) scan.sample->storage[static_cast<std::size_t>(i)].time_offset = 0.0F;
  log.add(event.utime, *scan.sample, utime);
  return Refusal::kNone;
}

}  // namespace

Recording convertLcm(const std::filesystem::path& in, const std::filesystem::path& out) {
  Recording recording;
  recording.format = "LCM log";
  std::map<std::string, int> channels;
  BeamTimes beam_times;
  {
    EventLogReader log(in);
    for (LogEvent event; log.next(event);) {
      if (channels.size() < 1000 || channels.contains(event.channel)) ++channels[event.channel];
      if (event.channel != channel::kScan) continue;
      const Received<scan_t> scan(event.data);
      if (scan && hasTimes(*scan.sample)) beam_times.add(scan.message->utime, scan.message->utime + span(*scan.sample));
    }
  }
  const auto copied_turn = beam_times.copiedTurn();
  if (copied_turn) recording.notes.push_back(noteOfCopiedTurns(*copied_turn));
  EventLogReader reader(in);
  LogOutput log;
  for (LogEvent event; reader.next(event);) {
    const std::string& name = event.channel;
    const std::string where = in.filename().string() + " " + name;
    std::int64_t utime = 0;
    const auto count = [&](Refusal refusal, void (Recording::*use)(SensorRows&, std::int64_t)) {
      SensorRows& rows = recording.sensor(name);
      if (refusal == Refusal::kNone) (recording.*use)(rows, utime);
      if (refusal != Refusal::kNone) recording.reject(rows, where, problemOf(refusal, name).words());
      channels.erase(name);
    };
    if (name == channel::kScan) {
      count(copyScan(event, copied_turn, log, utime), &Recording::useScan);
    } else if (name == channel::kWheels) {
      count(copy<wheels_t>(event, channel::kWheels, log, utime), &Recording::useWheels);
    } else if (name == channel::kImu) {
      count(copy<imu_t>(event, channel::kImu, log, utime), &Recording::useImu);
    } else if (name == channel::kConfig) {
      const auto message = decodeChecked<config_t>(event.data);
      if (message && !recording.configuration) recording.configuration = message->configuration;
      channels.erase(name);
    }
  }
  for (const auto& [name, messages] : channels) {
    recording.unused.push_back(name + ", " + std::to_string(messages) + " messages: of a kind that is not read");
  }
  if (recording.scans == 0) {
    throw std::runtime_error(in.string() +
                             ": an LCM log without scans that are known (SLAM_SCAN, or lidar_t of a Maebot or MBot)");
  }
  log.write(out, &recording);
  return recording;
}

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
