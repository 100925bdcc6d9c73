// SPDX-License-Identifier: BSD-3-Clause
#include "tools/bench/map_commands.hpp"

#include <cstdio>
#include <stdexcept>

#include "bus/event_log.hpp"
#include "bus/restamp.hpp"
#include "config/loader.hpp"
#include "store/map_store.hpp"
#include "tools/common/program.hpp"
#include "tools/common/trajectory.hpp"
#include "tools/replay/stats.hpp"

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
  CLI::App* const floors = app.add_subcommand("floors", "starts all over a log, in one of several maps");
  floors->add_option("--config", of_floors_.config, "slamd configuration (TOML)")->required();
  floors->add_option("--set", of_floors_.overrides, "section.key=value over the file; may be repeated");
  floors->add_option("--floor", of_floors_.which.truth, "name of the map that the log was driven in")->required();
  floors->add_option("--begin-in", of_floors_.which.begin_in, "name of the map that slamd goes on in")->required();
  floors->add_option("--floors", of_floors_.which.floors, "names of the maps that it is searched in")
      ->capture_default_str();
  floors->add_option("--places", of_floors_.which.places, "number of starts")
      ->capture_default_str()
      ->check(CLI::Range(1, 100000));
  floors->add_option("--seconds", of_floors_.which.seconds, "[s] that each drives at most")->capture_default_str();
  floors->add_flag("--verbose", of_floors_.verbose, "a line for each start");
  floors->add_option("LOG", in_, "LCM event log")->required();
  floors->add_option("MAPS", out_, "folder of the maps")->required();
  cut_ = cut, keyframes_ = keyframes, floors_ = floors, lift_ = addLift(app);
}

CLI::App* MapCommands::addLift(CLI::App& app) {
  CLI::App* const lift = app.add_subcommand("lift", "a drive in one of several maps, and with a lift to another");
  LiftDriveOptions& of_lift = of_floors_.lift;
  lift->add_option("--config", of_floors_.config, "slamd configuration (TOML)")->required();
  lift->add_option("--set", of_floors_.overrides, "section.key=value over the file; may be repeated");
  lift->add_option("--begin-in", of_lift.begin_in, "name of the map that slamd goes on in")->required();
  lift->add_option("--floors", of_lift.floors, "names of the maps that it is searched in")->capture_default_str();
  CLI::Option* const to =
      lift->add_option("--to", of_lift.arrive_in, "name of the map of the floor that the lift goes to");
  lift->add_option("--departs", of_lift.departs, "[s] since the log's begin, when the robot leaves the lift")
      ->needs(to);
  lift->add_option("LOG", in_, "LCM event log")->required();
  lift->add_option("MAPS", out_, "folder of the maps")->required();
  return lift;
}

void MapCommands::takeLift() const {
  const Config config = loadConfig(of_floors_.config, of_floors_.overrides);
  const LiftDriveReport report = driveWithLift(in_, out_, config, of_floors_.lift);
  std::printf(
      "sure_before=%d doubts=%d lost=%d doubt_s=%.1f unknown_s=%.1f known_s=%.1f known_m=%.1f "
      "wrong_and_sure_s=%.1f ends_in=%s ends_sure=%d\n",
      report.was_sure, report.doubts, report.lost, report.in_doubt, report.unknown, report.known, report.driven,
      report.wrong_and_sure, report.ends_in.c_str(), report.ends_sure);
}

void MapCommands::carryOut() const {
  cut_->parsed() ? cut() : keyframes_->parsed() ? writeKeyframes() : lift_->parsed() ? takeLift() : findFloors();
}

void MapCommands::findFloors() const {
  Config config = loadConfig(of_floors_.config, of_floors_.overrides);
  config.mode = RunMode::kLocalise;
  const WhichFloorReport report = whichFloor(in_, out_, config, of_floors_.which, [&](int done) {
    showProgress(std::to_string(done) + " of " + std::to_string(of_floors_.which.places) + " starts");
  });
  endProgress();
  std::vector<double> seconds;
  for (const FloorStart& start : report.starts) {
    if (!start.found.empty()) seconds.push_back(start.after);
    if (!of_floors_.verbose) continue;
    if (start.found.empty()) {
      std::printf("at %6.1f s: undecided%s\n", start.begin, start.doubt.c_str());
    } else {
      std::printf("at %6.1f s: %s after %4.1f s, %.2f m %.1f deg off\n", start.begin, start.found.c_str(), start.after,
                  start.error.translation, start.error.rotation);
    }
  }
  const auto after = quantiles(seconds);
  std::printf("%zu starts: %d right, %d wrong, %d undecided; median %.1f s, p99 %.1f s\n", report.starts.size(),
              report.right, report.wrong, report.undecided, after.p50, after.p99);
}

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
