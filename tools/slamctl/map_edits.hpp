// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <CLI/App.hpp>
#include <filesystem>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "config/config.hpp"

namespace slam {

/// Who runs this program.
std::string userName();

/// `slamctl map ...`: what a person draws into the map.
class MapEditing {
 public:
  /// Adds the subcommand.
  explicit MapEditing(CLI::App& app);
  bool parsed() const { return map_->parsed(); }
  /// The command to send, as verb and argument; nothing: edits() is asked for.
  /// @throws std::runtime_error with one sentence where the command line cannot be one
  std::optional<std::pair<std::string, std::string>> command() const;
  /// Prints the edits of a stored map. @param directory of the maps
  void list(const std::string& directory, const Config& config, bool json) const;

 private:
  CLI::App* map_;
  std::string name_;
  std::vector<double> numbers_, sigma_;  // [m, rad]
  int id_ = 0;
  bool force_ = false;
};

}  // namespace slam
