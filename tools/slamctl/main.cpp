// SPDX-License-Identifier: BSD-3-Clause
#include <CLI/App.hpp>
#include <algorithm>
#include <array>
#include <chrono>
#include <cstdio>
#include <iostream>
#include <nlohmann/json.hpp>

#include "config/loader.hpp"
#include "config/service_reach.hpp"
#include "drivers/device_status.hpp"
#include "store/log_policy.hpp"
#include "store/map_store.hpp"
#include "tools/common/program.hpp"
#include "tools/slamctl/doctor.hpp"
#include "tools/slamctl/health_json.hpp"
#include "tools/slamctl/log.hpp"
#include "tools/slamctl/map_edits.hpp"
#include "tools/slamctl/map_list.hpp"
#include "tools/slamctl/maps/map_export.hpp"
#include "tools/slamctl/maps/stored_map_commands.hpp"
#include "tools/slamctl/remote.hpp"
#include "tools/slamctl/report_command.hpp"
#include "tools/slamctl/setup/setup_command.hpp"
#include "tools/slamctl/web_address.hpp"

namespace {

using namespace std::chrono_literals;
constexpr auto kAnswerLimit = 20s;  // a large map on a slow disk
constexpr auto kHealthLimit = 3s;   // it comes at 1 Hz

void printJson(const nlohmann::json& value) { std::printf("%s\n", slam::textOf(value).c_str()); }

int printFindings(const slam::Findings& findings, bool json) {
  if (!json) return slam::print(findings);
  printJson(slam::findingsJson(findings));
  return static_cast<int>(std::count_if(findings.begin(), findings.end(), [](const slam::Finding& finding) {
    return finding.level == slam::Finding::kFault;
  }));
}

void exportMap(const slam::MapExport& map, bool all) {
  std::vector<std::string> remarks;
  const std::vector<std::string> lines = all ? map.writeAll(&remarks) : map.write(&remarks);
  for (const std::string& remark : remarks) std::cerr << "slamctl: " << remark << "\n";
  for (const std::string& line : lines) std::printf("%s\n", line.c_str());
}

void printStatus(const slam::health_t& health) {
  std::printf("%s\nup %.0f s, CPU %.1f %% of a core, memory %.0f MB\n", health.summary.c_str(), health.uptime,
              100.0 * health.cpu, health.memory_mb);
  for (const auto& device : health.devices) {
    std::printf("%-6s %-10s %6.1f Hz  rejected %lld  %s\n", device.name.c_str(),
                slam::nameOf(static_cast<slam::DeviceState>(device.state)), device.rate,
                static_cast<long long>(device.rejects), device.reason.c_str());
  }
  for (const auto& counter : health.counters) {
    for (const char* name : {"keyframes", "loop_closures", "lost", "relocalised"}) {
      if (counter.name == name) std::printf("%s %lld  ", name, static_cast<long long>(counter.value));
    }
  }
  std::printf("\n");
  const auto count = [&](const char* name) {
    const auto at = std::find_if(health.counters.begin(), health.counters.end(),
                                 [&](const slam::counter_t& counter) { return counter.name == name; });
    return at == health.counters.end() ? -1LL : static_cast<long long>(at->value);
  };
  if (count("log.running") < 0) return;
  const char* const states[] = {"not running (slamctl log start)", "running",
                                "wanted, but it cannot be written (the first line says why)"};
  std::printf("log %s: %lld messages written, %lld lost\n", states[std::clamp(count("log.running"), 0LL, 2LL)],
              count("log.written"), count("log.dropped"));
}

/// The folder of what slamd keeps: as configured, or the service's.
std::string folderOf(const std::string& configured, const char* service, const char* what, const char* key) {
  const std::string folder = configured.empty() && std::filesystem::is_directory(service) ? service : configured;
  if (folder.empty()) throw std::runtime_error(std::string("no folder of ") + what + "; set " + key);
  if (!std::filesystem::is_directory(folder)) throw std::runtime_error(folder + ": there is no such folder of " + what);
  return folder;
}

std::int64_t utimeNow() {
  const auto now = std::chrono::system_clock::now().time_since_epoch();
  return std::chrono::duration_cast<std::chrono::microseconds>(now).count();
}

void exportLog(const std::string& folder, const std::string& since, std::string out) {
  const std::int64_t now = utimeNow();
  if (out.empty()) out = "slamd-log-" + slam::utcName(now) + ".lcm";
  const auto done =
      slam::exportLogs(folder, since.empty() ? std::nullopt : std::optional(slam::sinceTime(since, now)), out);
  std::printf("%s: %llu records of %llu files, %s to %s (UTC)\n", out.c_str(),
              static_cast<unsigned long long>(done.records), static_cast<unsigned long long>(done.files),
              slam::timeText(done.first).c_str(), slam::timeText(done.last).c_str());
}

/// What the command line asks for.
struct Arguments {
  std::string config_file = slam::kServiceConfig, maps, name, prefix, url, what, since, out;
  std::vector<std::string> overrides;
  std::array<double, 3> pose{};
  bool json = false, zones = false, all = false, qr = false;
};

/// The subcommands that are looked at by themselves; the others are sent to slamd.
struct Commands {
  const CLI::App *status, *doctor, *web, *list, *maps, *export_map, *log_mark, *log_list, *log_export;
  std::vector<std::pair<const CLI::App*, const char*>> sent;  ///< with the command's verb
};

Commands addCommands(CLI::App& app, Arguments& arguments) {
  Commands commands{};
  app.add_option("--config", arguments.config_file, "slamd's configuration: its socket, LCM URL and folder of the maps")
      ->capture_default_str();
  app.add_option("--set", arguments.overrides, "section.key=value over the file; may be repeated");
  app.add_option("--url", arguments.url, "LCM URL, in place of the configuration's and of the socket");
  app.add_option("--maps", arguments.maps, "folder of the maps, in place of the configuration's");
  app.add_flag("--json", arguments.json, "print JSON, for programs (docs/api.md)");
  commands.status = app.add_subcommand("status", "what slamd does, and how its devices are");
  commands.doctor = app.add_subcommand(
      "doctor",
      "check devices, rights, rates, socket, LCM, real time, disk and clock, and print the fix for each fault");
  CLI::App* web = app.add_subcommand("web", "address of the page, and the fingerprint of its certificate");
  web->add_flag("--qr", arguments.qr, "print the address with its token as a QR code, for a phone's camera");
  commands.web = web;
  auto* save = app.add_subcommand("save", "store the map now; with a NAME, a copy under that name");
  save->add_option("NAME", arguments.name, "letters, digits, - and _");
  auto* load = app.add_subcommand("load", "store the present map and go on in another one");
  load->add_option("NAME", arguments.name, "of a map")->required();
  commands.list = app.add_subcommand("list", "all stored maps, and what slamd would find damaged in them");
  commands.maps = app.add_subcommand("maps", "the same as list");
  CLI::App* export_map = app.add_subcommand("export", "a stored map as map_server files");
  export_map->add_option("NAME", arguments.name, "of a map")->required()->check(slam::namesFile());
  commands.export_map = export_map;
  export_map->add_option("PREFIX", arguments.prefix, "of the .yaml, .pgm and .png to write")
      ->required()
      ->check(slam::namesFile());
  export_map->add_flag("--zones", arguments.zones,
                       "the keep-out mask and .geojson also where nothing is drawn into it");
  export_map->add_flag("--all", arguments.all,
                       "all of it in one PREFIX.zip, also as SVG, PLY (all points) and TUM (the path)");
  auto* set_pose = app.add_subcommand("set-pose", "say where the robot is in the map");
  set_pose->add_option("X", arguments.pose[0], "[m]")->required();
  set_pose->add_option("Y", arguments.pose[1], "[m]")->required();
  set_pose->add_option("THETA", arguments.pose[2], "[rad] counter-clockwise from the map's x axis")->required();
  const CLI::App* reset = app.add_subcommand("reset", "store the present map and begin a new one");
  auto* mode =
      app.add_subcommand("mode", "change the mode until slamd is started anew; afterwards the configuration's");
  mode->add_option("MODE", arguments.name, "localise: in the present map, which stays as it is; slam: and extend it")
      ->required()
      ->check(CLI::IsMember({"localise", "slam"}));
  auto* log = app.add_subcommand("log", "field logs: begin, end, mark, list and export them");
  log->require_subcommand(1);
  const CLI::App* log_start = log->add_subcommand("start", "begin to log");
  const CLI::App* log_stop = log->add_subcommand("stop", "end logging until log start, or the next start of slamd");
  CLI::App* log_mark = log->add_subcommand("mark", "note what has just happened; marked files are removed last");
  commands.log_mark = log_mark;
  log_mark->add_option("WHAT", arguments.what, "in words")->required();
  commands.log_list = log->add_subcommand("list", "all files of the logs, with their marks");
  CLI::App* log_export = log->add_subcommand("export", "one plain log for slam-replay or lcm-logplayer");
  commands.log_export = log_export;
  log_export->add_option("--since", arguments.since, "10min or 2h ago, or a UTC time; default: all");
  log_export->add_option("--out", arguments.out, "file to write; default: slamd-log-TIME.lcm")
      ->check(slam::namesFile());
  commands.sent = {{log_start, "log_start"}, {log_stop, "log_stop"}, {log_mark, "log_mark"}, {save, "save"},
                   {load, "load"},           {set_pose, "set_pose"}, {mode, "mode"},         {reset, "reset"}};
  for (CLI::App* command : app.get_subcommands({})) command->fallthrough();
  for (CLI::App* command : log->get_subcommands({})) command->fallthrough();
  return commands;
}

std::string folderOfMaps(const slam::Config& config) {
  return folderOf(config.store.directory, slam::kServiceMaps, "maps",
                  "store.directory in the configuration or give --maps");
}

/// What is looked up in the folders of maps and logs, whether slamd runs or not.
/// @param editing whose edits are listed; nullptr: none @return whether the command line asks for any of it
bool readFolders(const Commands& commands, const Arguments& arguments, const slam::Config& config,
                 const slam::MapEditing* editing) {
  const bool lists_maps = commands.list->parsed() || commands.maps->parsed();
  if (lists_maps || commands.export_map->parsed() || editing != nullptr) {
    const std::string directory = folderOfMaps(config);
    if (editing != nullptr) editing->list(directory, config, arguments.json);
    if (lists_maps) arguments.json ? printJson(slam::mapsJson(directory)) : slam::printMaps(directory);
    if (!commands.export_map->parsed()) return true;
    if (!slam::MapStore::isName(arguments.name))
      throw std::runtime_error("\"" + arguments.name + "\" is no name of a map");
    exportMap({.map = std::filesystem::path(directory) / arguments.name,
               .prefix = arguments.prefix,
               .grid = config.map,
               .zones = arguments.zones},
              arguments.all);
    return true;
  }
  if (!commands.log_list->parsed() && !commands.log_export->parsed()) return false;
  const std::string folder =
      folderOf(config.log.directory, slam::kServiceLog, "logs", "log.directory in the configuration");
  if (commands.log_export->parsed()) exportLog(folder, arguments.since, arguments.out);
  if (commands.log_list->parsed()) arguments.json ? printJson(slam::logsJson(folder)) : slam::printLogs(folder);
  return true;
}

/// @return false: slamd has refused one, and that is printed
bool sendAll(slam::Remote& remote, const slam::StoredMapCommands::Sent& sent, const Arguments& arguments) {
  for (const auto& [verb, argument] : sent) {
    const auto ack = remote.ask(verb, argument, arguments.pose, kAnswerLimit);
    if (!ack) throw std::runtime_error(remote.silence());
    if (arguments.json) printJson({{"accepted", ack->accepted != 0}, {"message", ack->message}});
    if (!ack->accepted && arguments.json) return false;
    if (!ack->accepted) throw std::runtime_error(ack->message);
    if (!arguments.json) std::printf("%s\n", ack->message.c_str());
  }
  return true;
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app("Asks and commands a running slamd; lists and exports its maps", "slamctl");
  app.require_subcommand(1);
  Arguments arguments;
  const slam::MapEditing editing(app);
  const slam::StoredMapCommands stored(app);
  const slam::ReportCommand report(app);
  const slam::SetupCommand setup(app);
  const Commands commands = addCommands(app, arguments);
  return slam::runProgram(app, argc, argv, SLAMD_VERSION, "slamctl save kitchen", [&] {
    if (report.parsed()) {
      report.run({arguments.config_file, arguments.url, SLAMD_VERSION, arguments.overrides, app.count("--config") > 0});
      return slam::kDone;
    }
    if (setup.parsed()) return setup.run(arguments.config_file, arguments.overrides) ? slam::kDone : slam::kFailed;
    const bool given = app.count("--config") > 0 || std::filesystem::exists(arguments.config_file);
    auto config = given ? slam::loadConfig(arguments.config_file, arguments.overrides)
                        : slam::parseConfig("", "defaults", arguments.overrides);
    if (!arguments.maps.empty()) config.store.directory = arguments.maps;
    if (!arguments.url.empty()) config.lcm.url = arguments.url;
    const auto edit = editing.parsed() ? editing.command() : std::nullopt;
    const bool lists_edits = editing.parsed() && !edit;
    slam::StoredMapCommands::Sent sent;
    if (edit) sent.push_back(*edit);
    if (stored.parsed()) {
      sent = stored.carryOut(folderOfMaps(config), config, utimeNow());
      if (sent.empty()) return slam::kDone;
    }
    if (readFolders(commands, arguments, config, lists_edits ? &editing : nullptr)) return slam::kDone;
    if (commands.web->parsed()) {
      slam::printWebAddress(config.web, arguments.qr);
      return slam::kDone;
    }
    const std::string socket = arguments.url.empty() ? slam::socketOf(config, arguments.config_file) : "";
    if (commands.doctor->parsed())
      return printFindings(slam::diagnose(config, socket), arguments.json) == 0 ? slam::kDone : slam::kFailed;
    slam::Remote remote(socket, config.lcm.url);
    if (commands.status->parsed()) {
      const auto health = remote.health(kHealthLimit);
      if (!health) throw std::runtime_error(remote.silence());
      arguments.json ? printJson(slam::healthJson(*health, remote.problems())) : printStatus(*health);
      return slam::kDone;
    }
    if (commands.log_mark->parsed()) arguments.name = arguments.what;
    for (const auto& [command, verb] : commands.sent)
      if (command->parsed()) sent.emplace_back(verb, arguments.name);
    return sendAll(remote, sent, arguments) ? slam::kDone : slam::kFailed;
  });
}
