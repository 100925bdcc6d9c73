// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <CLI/App.hpp>
#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "config/config.hpp"

namespace slam {

/// `slamctl edit`, `undo`, `straighten`, `delete`, `rename`, `merge` and `refine`: of maps by their names, whether
/// slamd has them open or not.
class StoredMapCommands {
 public:
  /// Adds the subcommands.
  explicit StoredMapCommands(CLI::App& app);
  bool parsed() const;

  /// What is asked for, one after another, as verb and argument for the slamd that has the map open.
  using Sent = std::vector<std::pair<std::string, std::string>>;
  /// Changes the map where no slamd has it open, and prints what was done.
  /// @param directory of the maps @param utime [us since the epoch] now @return what to send to the slamd that has it
  /// open; empty: it is done
  /// @throws std::runtime_error with one sentence where it cannot be done
  Sent carryOut(const std::string& directory, const Config& config, std::int64_t utime) const;

 private:
  void merge(const std::string& directory, const Config& config) const;
  void refine(const std::string& directory, const Config& config) const;

  const CLI::App *edit_, *undo_, *straighten_, *delete_, *rename_, *merge_, *refine_;
  std::string name_, second_, file_, to_, origin_, pictures_;
  bool furniture_moved_ = false;
};

}  // namespace slam
