// SPDX-License-Identifier: BSD-3-Clause
#include <CLI/App.hpp>
#include <CLI/Config.hpp>
#include <CLI/Formatter.hpp>
#include <csignal>
#include <cstdlib>
#include <iostream>
#include <optional>

#include "app/counters.hpp"
#include "app/log/log.hpp"
#include "app/map/map_keeper.hpp"
#include "app/supervisor.hpp"
#include "config/loader.hpp"
#include "config/printer.hpp"
#include "config/service_reach.hpp"
#include "runtime/realtime.hpp"

namespace {

constexpr int kFailed = 1, kBadUsage = 2, kBadConfig = 78;

int runDaemon(const slam::Config& config) {
  const sigset_t signals = slam::Supervisor::stopSignals();
  pthread_sigmask(SIG_BLOCK, &signals, nullptr);
  std::signal(SIGPIPE, SIG_IGN);
  slam::limitLibraryStacks();
  slam::shareOneHeap();
  try {
    slam::Supervisor supervisor(config);
    return supervisor.run();
  } catch (const std::exception& error) {
    slam::logError(error.what());
    return kFailed;
  }
}

/// As a service, systemd gives the folders where state is kept.
void useServiceFolders(slam::Config& config, const char* state, const char* runtime) {
  if (config.store.directory.empty() && state != nullptr) config.store.directory = std::string(state) + "/maps";
  if (config.runtime.socket.empty() && runtime != nullptr) config.runtime.socket = std::string(runtime) + "/socket";
  if (config.log.directory.empty() && state != nullptr) config.log.directory = std::string(state) + "/log";
}

/// What needs no configuration. @return whether it was wanted
bool printReference(const std::string& print_template, bool counters) {
  const auto keys = print_template == "all" ? slam::TemplateKeys::kAll : slam::TemplateKeys::kShown;
  if (!print_template.empty()) {
    std::cout << (print_template == "tuning" ? slam::printTuning() : slam::printTemplate(keys));
  } else if (counters) {
    std::cout << slam::printCounters();
  }
  return !print_template.empty() || counters;
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app("Real-time SLAM daemon for an indoor robot with lidar, wheels and IMU", "slamd");
  std::string config_file;
  std::vector<std::string> overrides;
  bool check = false, print = false, counters = false;
  std::string print_template;
  app.add_option("--config", config_file, "configuration (TOML)");
  app.add_option("--set", overrides, "section.key=value over the file; may be repeated");
  app.add_flag("--check-config", check, "check the configuration and exit");
  app.add_flag("--print-config", print, "print the effective configuration and exit");
  app.add_flag("--print-template{shown}", print_template,
               "print a configuration file that explains the keys for a robot and its site, and exit; =all: every key; "
               "=tuning: docs/tuning.md")
      ->check(CLI::IsMember({"shown", "all", "tuning"}));
  app.add_flag("--print-counters", counters, "print what each counter of SLAM_HEALTH counts, and exit");
  app.set_version_flag("--version", "slamd " SLAMD_VERSION);
  app.footer("Example:\n  slamd --config /etc/slamd/slamd.toml");
  try {
    app.parse(argc, argv);
  } catch (const CLI::Success& wanted) {
    return app.exit(wanted);
  } catch (const CLI::ParseError& error) {
    std::cerr << "slamd: " << error.what() << "; see slamd --help\n";
    return kBadUsage;
  }
  if (printReference(print_template, counters)) return 0;
  if (config_file.empty()) {
    std::cerr << "slamd: --config is required; see slamd --help\n";
    return kBadUsage;
  }
  slam::Config config;
  try {
    // Whoever checks the service's file need not have the service's rights.
    std::optional<slam::ServiceReach> reach;
    if (check && slam::isServiceConfig(config_file)) reach.emplace();
    config = slam::loadConfig(config_file, overrides, reach ? &*reach : nullptr);
    for (const std::string& line : config.notices) std::cerr << line << "\n";
  } catch (const slam::ConfigError& error) {
    std::cerr << error.what() << "\n";
    return kBadConfig;
  }
  const char* state = std::getenv("STATE_DIRECTORY");
  useServiceFolders(config, state, std::getenv("RUNTIME_DIRECTORY"));
  if (const std::string wrong = slam::MapKeeper::misconfiguration(config); !wrong.empty()) {
    std::cerr << config_file << ":1:1: " << wrong << "\n";
    return kBadConfig;
  }
  // A pose is worth more than a file that cannot be written: no reason not to start.
  if (!check && !print && state != nullptr && slam::isServiceConfig(config_file)) {
    for (const auto& problem : slam::ServiceReach().problemsOf(config))
      slam::logWarning(problem.key + (": " + problem.what + "; " + problem.fix));
  }
  if (print) std::cout << slam::printConfig(config);
  if (check && !print) std::cout << config_file << ": good\n";
  return check || print ? 0 : runDaemon(config);
}
