// SPDX-License-Identifier: BSD-3-Clause
#include "tools/slamctl/report_command.hpp"

#include <chrono>
#include <cstdio>
#include <filesystem>
#include <iostream>
#include <stdexcept>
#include <unistd.h>

#include "config/loader.hpp"
#include "store/log_policy.hpp"
#include "tools/common/output_file.hpp"
#include "tools/common/program.hpp"
#include "tools/slamctl/health_json.hpp"
#include "tools/slamctl/remote.hpp"
#include "tools/slamctl/report.hpp"

namespace slam {
namespace {

using namespace std::chrono_literals;
namespace fs = std::filesystem;
constexpr auto kHealthLimit = 3s;  // it comes at 1 Hz

std::string nameOfNow() {
  const auto now = std::chrono::system_clock::now().time_since_epoch();
  return "slamd-report-" + utcName(std::chrono::duration_cast<std::chrono::microseconds>(now).count()) + ".zip";
}

/// Where a person sits, whether that person agrees.
bool confirmed(const fs::path& out) {
  if (isatty(STDIN_FILENO) == 0) throw std::runtime_error("no terminal to ask on; give --yes");
  std::printf(
      "The report holds versions, the configuration without the web page's section, what doctor finds with names and\n"
      "serial numbers of devices, slamd's status, and the last two minutes of the field log: scans and motion of the\n"
      "robot, from which the shape of the rooms can be seen.\nWrite %s? [y/N] ",
      out.c_str());
  std::fflush(stdout);
  std::string answer;
  std::getline(std::cin, answer);
  return answer == "y" || answer == "Y" || answer == "yes";
}

}  // namespace

ReportCommand::ReportCommand(CLI::App& app)
    : command_(app.add_subcommand(
          "report", "one zip for a bug report: versions, configuration without secrets, doctor, status, newest log")) {
  command_->add_option("--out", out_, "file to write; default: slamd-report-TIME.zip")->check(namesFile());
  command_->add_flag("--yes", yes_, "write it without asking");
}

void ReportCommand::run(const Options& options) const {
  const fs::path out = fs::absolute(out_.empty() ? nameOfNow() : out_);
  if (!yes_ && !confirmed(out)) {
    std::printf("nothing was written\n");
    return;
  }
  prepareOutput(out);
  const auto configuration = [&] {
    const bool given = options.config_given || fs::exists(options.config_file);
    return given ? loadConfig(options.config_file, options.overrides) : parseConfig("", "defaults", options.overrides);
  };
  Config config;  // the defaults, where it is a wrong one
  try {
    config = configuration();
  } catch (const std::runtime_error&) {  // the report has its words
  }
  if (!options.url.empty()) config.lcm.url = options.url;
  const std::string socket = options.url.empty() ? socketOf(config, options.config_file) : "";
  const auto status = [&] {
    Remote remote(socket, config.lcm.url);
    const auto health = remote.health(kHealthLimit);
    if (!health) throw std::runtime_error(remote.silence());
    return healthJson(*health, remote.problems());
  };
  std::error_code error;
  const bool service = config.log.directory.empty() && fs::is_directory(kServiceLog, error);
  const ReportSources sources{.version = options.version,
                              .configuration = configuration,
                              .doctor = [&] { return diagnose(config, socket); },
                              .status = status,
                              .logs = service ? kServiceLog : config.log.directory};
  const std::vector<std::string> lines = writeReport(sources, out);
  std::printf("%s\n", out.c_str());
  for (const std::string& line : lines) std::printf("  %s\n", line.c_str());
}

}  // namespace slam
