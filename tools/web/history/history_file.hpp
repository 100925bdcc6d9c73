// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <filesystem>
#include <optional>

#include "tools/web/history/day_history.hpp"

namespace slam {

/// Where slam-web's last day outlives slam-web: history.json in the folder that systemd gives the service.
class HistoryFile {
 public:
  /// @param folder that is there; empty: nothing is kept
  explicit HistoryFile(const std::filesystem::path& folder);

  /// @return std::nullopt where there is none @throws std::runtime_error for a file that cannot be read, or is damaged
  std::optional<DayHistory> read() const;
  /// In place of the last one, at once: a power cut leaves one of them. @throws std::runtime_error with the reason
  void write(const DayHistory& history) const;

 private:
  std::filesystem::path file_;  // empty: none
};

}  // namespace slam
