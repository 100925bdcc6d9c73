// SPDX-License-Identifier: BSD-3-Clause
#include "store/edit_codec.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "core/plausibility.hpp"
#include "store/binary.hpp"

namespace slam {
namespace {

constexpr std::size_t kEditBytes = 86, kCornerBytes = 20, kOutlineBytes = 16, kAnchorBytes = 28,
                      kStepBytes = 5;  // at least

void requireEdit(bool plausible, const char* words) {
  if (!plausible) throw std::runtime_error(words);
}

void put(BinaryWriter& out, const std::string& text) {
  out.put(static_cast<std::uint64_t>(text.size()));
  out.putBytes(text);
}

std::string getText(BinaryReader& in) { return std::string(in.getBytes(in.getCount(1))); }

void put(BinaryWriter& out, const Eigen::Vector2d& p) {
  out.put(p.x());
  out.put(p.y());
}

Eigen::Vector2d getPoint(BinaryReader& in) {
  const auto x = in.get<double>();
  return {x, in.get<double>()};
}

/// What decodeEdits() takes; encodeEdits() asks the same.
void check(const MapEdit& edit, int keyframes) {
  constexpr double kFarthest = 2.0 * kPlausible.stored_farthest;
  const auto isNear = [](const Eigen::Vector2d& p) { return isWithin(p.x(), kFarthest) && isWithin(p.y(), kFarthest); };
  requireEdit(edit.kind <= EditKind::kPlace, "holds an edit of an unknown kind");
  requireEdit(edit.name.size() <= kEditLimits.name_bytes && edit.author.size() <= kEditLimits.name_bytes,
              "holds an edit whose name is too long");
  requireEdit(!edit.corners.empty() && edit.corners.size() <= kEditLimits.corners, "holds an edit without a place");
  for (const MapEdit::Corner& corner : edit.corners)
    requireEdit(corner.keyframe >= 0 && corner.keyframe < keyframes && isNear(corner.p_keyframe),
                "holds an edit of a keyframe that is not there, or too far from it");
  requireEdit(edit.outline.empty() == (edit.kind != EditKind::kErase) && edit.outline.size() <= kEditLimits.corners &&
                  std::all_of(edit.outline.begin(), edit.outline.end(), isNear),
              "holds an edit with an outline that cannot be");
  for (const auto& [keyframe, T_keyframe_map] : edit.T_keyframe_map)
    requireEdit(keyframe >= 0 && keyframe < keyframes && isPlausible(T_keyframe_map, kFarthest),
                "holds an edit that erases of a keyframe that is not there");
  requireEdit(isWithin(edit.theta, kPlausible.turn) && (edit.sigma.array() >= 0.0).all() &&
                  (edit.sigma.array() <= kEditLimits.widest_sigma).all(),
              "holds a place whose heading or sigma cannot be");
}

void put(BinaryWriter& out, const MapEdit& edit) {
  out.put(static_cast<std::int32_t>(edit.id));
  out.put(static_cast<std::uint8_t>(edit.active));
  out.put(static_cast<std::uint8_t>(edit.kind));
  put(out, edit.name);
  put(out, edit.author);
  out.put(edit.utime);
  for (const double value : {edit.theta, edit.sigma.x(), edit.sigma.y(), edit.sigma.z()}) out.put(value);
  out.put(static_cast<std::uint64_t>(edit.corners.size()));
  for (const MapEdit::Corner& corner : edit.corners) {
    out.put(static_cast<std::int32_t>(corner.keyframe));
    put(out, corner.p_keyframe);
  }
  out.put(static_cast<std::uint64_t>(edit.outline.size()));
  for (const Eigen::Vector2d& p : edit.outline) put(out, p);
  out.put(static_cast<std::uint64_t>(edit.T_keyframe_map.size()));
  for (const auto& [keyframe, T] : edit.T_keyframe_map) {
    out.put(static_cast<std::int32_t>(keyframe));
    for (const double value : {T.x, T.y, T.theta}) out.put(value);
  }
}

MapEdit getEdit(BinaryReader& in) {
  MapEdit edit;
  edit.id = in.get<std::int32_t>();
  edit.active = in.get<std::uint8_t>() != 0;
  edit.kind = static_cast<EditKind>(in.get<std::uint8_t>());
  edit.name = getText(in);
  edit.author = getText(in);
  edit.utime = in.get<std::int64_t>();
  edit.theta = in.get<double>();
  for (int i = 0; i < 3; ++i) edit.sigma[i] = in.get<double>();
  edit.corners.resize(in.getCount(kCornerBytes));
  for (MapEdit::Corner& corner : edit.corners) {
    corner.keyframe = in.get<std::int32_t>();
    corner.p_keyframe = getPoint(in);
  }
  edit.outline.resize(in.getCount(kOutlineBytes));
  for (Eigen::Vector2d& p : edit.outline) p = getPoint(in);
  for (std::size_t left = in.getCount(kAnchorBytes); left > 0; --left) {
    const auto keyframe = in.get<std::int32_t>();
    const auto x = in.get<double>(), y = in.get<double>();
    edit.T_keyframe_map[keyframe] = {x, y, in.get<double>()};
  }
  return edit;
}

void check(const MapEdits& edits, int keyframes) {
  constexpr int kMost = 1'000'000'000;  // an edit a second for 30 years
  requireEdit(edits.made >= 0 && edits.made < kMost && edits.revision >= 0 && edits.revision < kMost,
              "counts more edits than anybody makes");
  int before = 0;
  for (const MapEdit& edit : edits.edits) {
    requireEdit(edit.id > before && edit.id <= edits.made, "holds edits that are not in their order");
    check(edit, keyframes);
    before = edit.id;
  }
  requireEdit(edits.done <= edits.steps.size() && edits.steps.size() <= kEditLimits.steps,
              "undoes more steps than there are");
  for (const MapEdits::Step& step : edits.steps)
    requireEdit(
        std::any_of(edits.edits.begin(), edits.edits.end(), [&](const MapEdit& edit) { return edit.id == step.id; }),
        "holds a step of an edit that is not there");
}

}  // namespace

std::string encodeEdits(const MapState& map) {
  check(map.edits, map.keyframes.size());
  BinaryWriter out;
  out.put(static_cast<std::int32_t>(map.edits.made));
  out.put(static_cast<std::int32_t>(map.edits.revision));
  out.put(static_cast<std::uint64_t>(map.edits.edits.size()));
  for (const MapEdit& edit : map.edits.edits) put(out, edit);
  out.put(static_cast<std::uint64_t>(map.edits.steps.size()));
  for (const MapEdits::Step& step : map.edits.steps) {
    out.put(static_cast<std::int32_t>(step.id));
    out.put(static_cast<std::uint8_t>(step.removes));
  }
  out.put(static_cast<std::uint64_t>(map.edits.done));
  out.put(static_cast<std::uint64_t>(map.views.size()));
  for (const MapView& view : map.views) out.put(static_cast<std::int32_t>(view.edit));
  return out.take();
}

void decodeEdits(std::string_view bytes, MapState& map) {
  BinaryReader in(bytes);
  MapEdits edits;
  edits.made = in.get<std::int32_t>();
  edits.revision = in.get<std::int32_t>();
  for (std::size_t left = in.getCount(kEditBytes); left > 0; --left) edits.edits.push_back(getEdit(in));
  edits.steps.resize(in.getCount(kStepBytes));
  for (MapEdits::Step& step : edits.steps) {
    step.id = in.get<std::int32_t>();
    step.removes = in.get<std::uint8_t>() != 0;
  }
  edits.done = static_cast<std::size_t>(in.get<std::uint64_t>());
  std::vector<int> seen_after(in.getCount(sizeof(std::int32_t)));
  for (int& edit : seen_after) edit = in.get<std::int32_t>();
  check(edits, map.keyframes.size());
  edits.whole = std::move(map.edits.whole);
  map.edits = std::move(edits);
  for (std::size_t i = 0; i < std::min(seen_after.size(), map.views.size()); ++i) map.views[i].edit = seen_after[i];
  eraseFrom(map.keyframes, map.edits);
}

}  // namespace slam
