// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <CLI/App.hpp>
#include <filesystem>
#include <string>
#include <vector>

#include "config/config.hpp"
#include "tools/slamctl/setup/console.hpp"

namespace slam {

/// `slamctl setup` on the command line: from what is plugged in to a configuration that doctor finds no fault with.
class SetupCommand {
 public:
  /// The configuration in use: its text, its values, and what it sets.
  struct Present {
    std::string text;
    Config config;  ///< as the file has it
    Config start;   ///< with the command line's --set over it
    std::vector<std::string> set;
  };

  /// Adds the subcommand.
  explicit SetupCommand(CLI::App& app);
  bool parsed() const { return command_->parsed(); }

  /// Looks, asks, calibrates, writes, and runs doctor's checks.
  /// @param config_file in use; need not be there @return whether doctor finds no fault, and all was written
  /// @throws ConfigError, std::runtime_error
  bool run(const std::string& config_file, const std::vector<std::string>& overrides) const;

 private:
  bool carryOut(const Present& present, const std::filesystem::path& target, Console& console) const;

  CLI::App* command_;
  std::string answers_, write_;
  std::vector<std::string> ports_;
  bool yes_ = false, calibrate_ = false, stop_service_ = false, web_ = false, qr_ = false;
  int web_port_ = -1;
  double seconds_;  // of the drive
};

}  // namespace slam
