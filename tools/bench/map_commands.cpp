// SPDX-License-Identifier: BSD-3-Clause
#include "tools/bench/map_commands.hpp"

#include <stdexcept>

#include "bus/event_log.hpp"
#include "bus/restamp.hpp"
#include "store/map_store.hpp"
#include "tools/common/program.hpp"
#include "tools/common/trajectory.hpp"

namespace slam {

MapCommands::MapCommands(CLI::App& app) {
  CLI::App* const cut = app.add_subcommand("cut", "a part of a log");
  cut->add_option("LOG", in_, "LCM event log")->required();
  cut->add_option("OUT", out_, "log to write")->required();
  cut->add_option("--from", from_, "[1] share of the log's time")->check(inRange(0.0, 1.0))->capture_default_str();
  cut->add_option("--to", to_, "[1] share of the log's time")->check(inRange(0.0, 1.0))->capture_default_str();
  cut->add_option("--later", later_, "[s] that its stamps are later than they were")->capture_default_str();
  CLI::App* const keyframes = app.add_subcommand("keyframes", "the poses of a stored map's keyframes (TUM)");
  keyframes->add_option("MAP", in_, "DIR/NAME of a store")->required();
  keyframes->add_option("OUT", out_, "trajectory to write")->required();
  cut_ = cut, keyframes_ = keyframes;
}

void MapCommands::carryOut() const { cut_->parsed() ? cut() : writeKeyframes(); }

void MapCommands::cut() const {
  LogEvent event;
  std::int64_t first = 0, last = 0;
  for (EventLogReader log(in_); log.next(event); last = event.utime) {
    if (first == 0) first = event.utime;
  }
  const auto at = [&](double share) {
    return first + static_cast<std::int64_t>(share * static_cast<double>(last - first));
  };
  const auto later = static_cast<std::int64_t>(1e6 * later_);
  EventLogWriter out(out_);
  std::vector<std::uint8_t> room;
  for (EventLogReader log(in_); log.next(event);) {
    if (event.utime < at(from_) || event.utime > at(to_)) continue;
    out.write(event.utime + later, event.channel, restamped(event.data, utimeOf(event.data) + later, room));
  }
  if (!out.flush()) throw std::runtime_error(out_ + ": cannot write");
}

void MapCommands::writeKeyframes() const {
  const MapState map = openMap(in_, {}).state;
  TrajectoryWriter out(out_);
  for (int id = 0; id < map.keyframes.size(); ++id) {
    if (map.in_map[static_cast<std::size_t>(id)] == 0) continue;
    out.write(toMicroseconds(map.keyframes.scan(id)->stamp), map.keyframes.pose(id));
  }
  out.close();
}

}  // namespace slam
