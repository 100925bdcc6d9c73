// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <CLI/App.hpp>
#include <string>
#include <vector>

namespace slam {

/// `slamctl report` on the command line.
class ReportCommand {
 public:
  /// Adds the subcommand.
  explicit ReportCommand(CLI::App& app);
  bool parsed() const { return command_->parsed(); }

  /// What the other options of the command line are.
  struct Options {
    std::string config_file, url, version;
    std::vector<std::string> overrides;
    bool config_given = false;
  };
  /// Asks on a terminal, writes the report and prints what is in it; also where the configuration is a wrong one.
  /// @throws std::runtime_error where nobody can be asked, or it cannot be written
  void run(const Options& options) const;

 private:
  CLI::App* command_;
  std::string out_;
  bool yes_ = false;
};

}  // namespace slam
