// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <cstdint>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <slam/map_edit_t.hpp>
#include <vector>

namespace slam {

/// What is drawn into the present map: edits of SLAM_MAP_EDITS, which come one a message. Its memory is bounded
/// whatever comes. Pure.
class EditBoard {
 public:
  static constexpr std::size_t kMostPoints = 20'000;  ///< of all edits; a stream of events holds no more

  /// Another map: forgets all edits.
  void begin(std::int32_t map_id);
  /// @return false for a message that no slamd sends
  bool take(const map_edit_t& message);

  /// Grows with each change of edits().
  std::uint64_t serial() const { return serial_; }
  const std::vector<map_edit_t>& edits() const { return edits_; }

 private:
  std::int32_t map_id_ = 0, revision_ = -1;
  std::vector<std::optional<map_edit_t>> coming_;  // of this revision, by index
  std::vector<map_edit_t> edits_;                  // of the newest revision that was whole
  std::uint64_t serial_ = 0;
};

/// Edits as docs/api.md has them; those behind kMostPoints points are left out.
nlohmann::json editsJson(const EditBoard& board);

}  // namespace slam
