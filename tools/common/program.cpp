// SPDX-License-Identifier: BSD-3-Clause
#include "tools/common/program.hpp"

#include <CLI/Config.hpp>
#include <CLI/Formatter.hpp>
#include <CLI/TypeTools.hpp>
#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <iostream>
#include <sstream>
#include <unistd.h>
#include <vector>

#include "config/closest_word.hpp"
#include "config/loader.hpp"

namespace slam {
namespace {

/// The subcommand or option that a word of the command line is nearly; empty: none is.
std::string meantBy(const CLI::App& app, int argc, char** argv) {
  std::vector<std::string> known;
  for (const CLI::App* command : app.get_subcommands(nullptr)) {
    known.push_back(command->get_name());
    for (const CLI::App* inner : command->get_subcommands(nullptr)) known.push_back(inner->get_name());
  }
  for (const CLI::Option* option : app.get_options()) known.push_back(option->get_name());
  for (const std::string& word : std::vector<std::string>(argv + 1, argv + argc)) {
    if (word.size() < 3 || std::find(known.begin(), known.end(), word) != known.end()) continue;
    if (std::string meant = closestWord(word, known); !meant.empty()) return meant;
  }
  return "";
}

}  // namespace

int runProgram(CLI::App& app, int argc, char** argv, const std::string& version, const std::string& example,
               const std::function<int()>& body) {
  app.set_version_flag("--version", app.get_name() + " " + version);
  app.footer("Example:\n  " + example);
  try {
    app.parse(argc, argv);
  } catch (const CLI::CallForHelp& help) {
    return app.exit(help);
  } catch (const CLI::CallForAllHelp& help) {
    return app.exit(help);
  } catch (const CLI::CallForVersion& wanted) {
    return app.exit(wanted);
  } catch (const CLI::ParseError& error) {
    const std::string meant = meantBy(app, argc, argv);
    std::cerr << app.get_name() << ": " << error.what() << (meant.empty() ? "" : "; did you mean " + meant + "?")
              << "; see " << app.get_name() << " --help\n";
    return kBadUsage;
  }
  try {
    return body();
  } catch (const ConfigError& error) {
    std::cerr << error.what() << "\n";
    return kBadConfig;
  } catch (const CLI::ValidationError& error) {  // options that do not go together with the configuration
    std::cerr << app.get_name() << ": " << error.what() << "; see " << app.get_name() << " --help\n";
    return kBadUsage;
  } catch (const std::exception& error) {
    endProgress();
    std::cerr << app.get_name() << ": " << error.what() << "\n";
    return kFailed;
  }
}

CLI::Validator inRange(double least, double most) {
  std::ostringstream limits;
  limits << "[" << least << " - " << most << "]";
  const auto check = [least, most, text = limits.str()](const std::string& value) {
    double number = 0.0;
    const bool inside = CLI::detail::lexical_cast(value, number) && number >= least && number <= most;
    return inside ? std::string() : value + " is not in " + text;
  };
  return {check, "FLOAT in " + limits.str()};
}

CLI::Validator namesFile() {
  const auto check = [](const std::string& value) {
    const bool named = !std::filesystem::path(value).filename().empty();
    return named ? std::string() : "'" + value + "' ends in no name";
  };
  return {check, ""};
}

void showProgress(const std::string& text) {
  if (isatty(STDERR_FILENO)) std::fprintf(stderr, "\r%s\033[K", text.c_str());
}

void endProgress() {
  if (isatty(STDERR_FILENO)) std::fprintf(stderr, "\r\033[K");
}

}  // namespace slam
