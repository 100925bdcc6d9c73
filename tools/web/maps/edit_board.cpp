// SPDX-License-Identifier: BSD-3-Clause
#include "tools/web/maps/edit_board.hpp"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "slam/edits/map_edit.hpp"
#include "tools/slamctl/health_json.hpp"

namespace slam {
namespace {

bool isSound(const map_edit_t& edit) {
  const auto most = static_cast<std::int32_t>(kEditLimits.edits);
  if (edit.edits == 0) return true;
  const auto finite = [](double value) { return std::isfinite(value); };
  return edit.edits > 0 && edit.edits <= most && edit.index >= 0 && edit.index < edit.edits && edit.npoints > 0 &&
         edit.x.size() <= kEditLimits.corners && edit.x.size() == edit.y.size() &&
         std::all_of(edit.x.begin(), edit.x.end(), finite) && std::all_of(edit.y.begin(), edit.y.end(), finite) &&
         finite(edit.theta) && editKindOf(edit.kind) && edit.name.size() <= kEditLimits.name_bytes &&
         edit.author.size() <= kEditLimits.name_bytes;
}

bool isSame(const map_edit_t& a, const map_edit_t& b) {
  return a.id == b.id && a.revision == b.revision && a.x == b.x && a.y == b.y && a.theta == b.theta;
}

}  // namespace

void EditBoard::begin(std::int32_t map_id) {
  if (map_id == map_id_) return;
  map_id_ = map_id;
  revision_ = -1;
  coming_.clear();
  edits_.clear();
  ++serial_;
}

bool EditBoard::take(const map_edit_t& message) {
  if (!isSound(message)) return false;
  if (message.map_id != map_id_) return true;  // of the map before, or of the next one, which is sent again
  if (message.revision != revision_ || coming_.size() != static_cast<std::size_t>(message.edits)) {
    revision_ = message.revision;
    coming_.assign(static_cast<std::size_t>(message.edits), std::nullopt);
  }
  if (message.edits > 0) coming_[static_cast<std::size_t>(message.index)] = message;
  if (!std::all_of(coming_.begin(), coming_.end(), [](const auto& edit) { return edit.has_value(); })) return true;
  const bool same = std::equal(coming_.begin(), coming_.end(), edits_.begin(), edits_.end(),
                               [](const auto& edit, const map_edit_t& shown) { return isSame(*edit, shown); });
  if (same) return true;
  edits_.clear();
  for (const auto& edit : coming_) edits_.push_back(*edit);
  ++serial_;
  return true;
}

nlohmann::json editsJson(const EditBoard& board) {
  auto list = nlohmann::json::array();
  std::size_t count = 0;
  for (const map_edit_t& edit : board.edits()) {
    count += edit.x.size();
    if (count > EditBoard::kMostPoints) break;
    auto points = nlohmann::json::array();
    for (std::size_t i = 0; i < edit.x.size(); ++i)
      points.push_back({rounded(edit.x[i], 1e3), rounded(edit.y[i], 1e3)});
    list.push_back({{"id", edit.id},
                    {"kind", edit.kind},
                    {"name", edit.name},
                    {"by", edit.author},
                    {"utime", edit.utime},
                    {"theta", rounded(edit.theta)},
                    {"points", std::move(points)}});
  }
  return list;
}

}  // namespace slam
