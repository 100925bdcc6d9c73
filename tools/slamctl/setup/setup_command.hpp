// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <CLI/App.hpp>
#include <string>
#include <vector>

namespace slam {

/// `slamctl setup` on the command line: from what is plugged in to a configuration that doctor finds no fault with.
class SetupCommand {
 public:
  /// Adds the subcommand.
  explicit SetupCommand(CLI::App& app);
  bool parsed() const { return command_->parsed(); }

  /// Looks, asks, calibrates, writes, and runs doctor's checks.
  /// @param config_file in use; need not be there @return whether doctor finds no fault, and all was written
  /// @throws ConfigError, std::runtime_error
  bool run(const std::string& config_file, const std::vector<std::string>& overrides) const;

 private:
  CLI::App* command_;
  std::string answers_, write_;
  std::vector<std::string> ports_;
  bool yes_ = false, calibrate_ = false, stop_service_ = false;
  double seconds_;  // of the drive
};

}  // namespace slam
