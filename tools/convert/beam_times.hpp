// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "tools/convert/recording.hpp"

namespace slam {

/// Finds out whether the times of a turning lidar's beams are those of its driver, which copied a turn that was
/// complete: they span next to nothing of the time from scan to scan. Such a turn was measured before its stamps.
class BeamTimes {
 public:
  /// @param first, last [us] of the scan's beams
  void add(std::int64_t first, std::int64_t last);

  /// [us] that a turn takes where the beams' times are those of a copy; nullopt: they are not
  std::optional<std::int64_t> copiedTurn() const;

 private:
  std::vector<std::int64_t> spans_, periods_;  // [us]
  std::optional<std::int64_t> last_;
};

/// What a person should know of scans that are used so.
std::string noteOfCopiedTurns(std::int64_t turn);

}  // namespace slam
