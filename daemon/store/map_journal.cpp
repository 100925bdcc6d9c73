// SPDX-License-Identifier: BSD-3-Clause
#include "store/map_journal.hpp"

#include <algorithm>

#include "store/edit_codec.hpp"
#include "store/map_codec.hpp"

namespace slam {
namespace {

enum Entry : std::uint8_t {
  kNode = 1,
  kEdge = 2,
  kPoses = 3,
  kInMap = 4,
  kRevoked = 5,
  kState = 6,
  kBase = 7,
  kView = 8,
  kEdits = 9
};
constexpr std::uint32_t kMagic = 0x4A4D4C53;        // "SLMJ"
constexpr std::size_t kHeader = 12;                 // [bytes] magic, size and CRC
constexpr std::uint32_t kLargestRecord = 1U << 28;  // [bytes] what is larger is a checkpoint's

void putEntry(BinaryWriter& out, Entry kind, std::string_view payload) {
  out.put(static_cast<std::uint8_t>(kind));
  out.put(static_cast<std::uint64_t>(payload.size()));
  out.putBytes(payload);
}

std::string recordOf(std::string_view entries) {
  if (entries.size() > kLargestRecord) throw UnreadableMap("more has changed than a record of a journal may hold");
  BinaryWriter out;
  out.put(kMagic);
  out.put(static_cast<std::uint32_t>(entries.size()));
  out.put(crc32Of(entries));
  out.putBytes(entries);
  return out.take();
}

/// What entries may refer to: a journal fits no other map.
std::uint32_t fingerprintOf(const MapState& map) {
  BinaryWriter out;
  encodePoses(out, map.keyframes.graph().poses());
  out.putBytes({map.in_map.data(), map.in_map.size()});
  for (const Edge& edge : map.keyframes.graph().edges()) out.put(static_cast<std::uint8_t>(edge.revoked));
  return crc32Of(out.bytes());
}

void applyEntry(Entry kind, std::string_view bytes, MapState& map, MapJournal::Replayed& replayed) {
  BinaryReader in(bytes);
  switch (kind) {
    case kNode:
      decodeNode(in, map);
      break;
    case kEdge:
      decodeEdge(in, map);
      break;
    case kPoses:
      decodePoses(in, map);
      replayed.moved = true;
      break;
    case kInMap: {
      const auto first = in.get<std::uint32_t>(), end = in.get<std::uint32_t>();
      if (first > end || end > map.in_map.size()) throw std::runtime_error("names a keyframe that is not there");
      std::fill(map.in_map.begin() + first, map.in_map.begin() + end, 1);
      replayed.moved = true;
      break;
    }
    case kRevoked: {
      const auto edge = in.get<std::uint32_t>();
      const bool revoked = in.get<std::uint8_t>() != 0;
      if (edge >= map.keyframes.graph().edges().size()) throw std::runtime_error("names an edge that is not there");
      revoked ? map.keyframes.graph().revoke(static_cast<int>(edge))
              : map.keyframes.graph().restore(static_cast<int>(edge));
      break;
    }
    case kState: {
      const int drawn = map.grid_keyframes;  // the grid is still the checkpoint's
      decodeState(bytes, map);
      map.grid_keyframes = drawn;
      break;
    }
    case kView:
      map.views.push_back(decodeView(in, map));
      map.views.back().edit = map.edits.made;
      replayed.seen.push_back(map.views.back());
      break;
    case kEdits:
      decodeEdits(bytes, map);
      replayed.moved = true;
      break;
    case kBase:
      if (in.get<std::uint32_t>() != fingerprintOf(map)) throw std::runtime_error("continues another map");
      break;
    default:
      throw std::runtime_error("holds an entry of an unknown kind");
  }
}

void applyRecord(std::string_view record, MapState& map, MapJournal::Replayed& replayed) {
  for (BinaryReader entries(record); !entries.atEnd();) {
    const auto kind = static_cast<Entry>(entries.get<std::uint8_t>());
    applyEntry(kind, entries.getBytes(entries.getCount(1)), map, replayed);
  }
}

/// Reads as replay() will what is about to be written: a record that it refuses would hide all that come after it.
void requireReadable(std::string_view record, const MapState& map) {
  MapState again;
  again.keyframes = map.keyframes;  // scans are shared
  again.in_map = map.in_map;
  again.edits = map.edits;
  MapJournal::Replayed ignored;
  try {
    applyRecord(record, again, ignored);
  } catch (const std::runtime_error& error) {
    throw UnreadableMap(std::string("what has changed ") + error.what());
  }
}

}  // namespace

MapJournal::MapJournal(const std::filesystem::path& file, const MapState& known) : file_(file, 0) {
  BinaryWriter base, entries;
  base.put(fingerprintOf(known));
  putEntry(entries, kBase, base.bytes());
  file_.append(recordOf(entries.bytes()));
  remember(known);
}

void MapJournal::remember(const MapState& map) {
  const auto poses = map.keyframes.graph().poses();
  poses_.assign(poses.begin(), poses.end());
  in_map_ = map.in_map;
  revoked_.clear();
  for (const Edge& edge : map.keyframes.graph().edges()) revoked_.push_back(edge.revoked);
  state_ = encodeState(map);
  edits_ = map.edits.revision;
}

void MapJournal::append(const MapState& map, std::span<const MapView> seen) {
  BinaryWriter out;
  const PoseGraph& graph = map.keyframes.graph();
  const bool moved = !std::equal(poses_.begin(), poses_.end(), graph.poses().begin());
  for (int id = static_cast<int>(poses_.size()); id < graph.size(); ++id) {
    BinaryWriter node;
    encodeNode(node, wholeScan(map, id), graph.pose(id), map.in_map[static_cast<std::size_t>(id)] != 0);
    putEntry(out, kNode, node.bytes());
  }
  for (std::size_t e = revoked_.size(); e < graph.edges().size(); ++e) {
    BinaryWriter edge;
    encodeEdge(edge, graph.edges()[e]);
    putEntry(out, kEdge, edge.bytes());
  }
  for (std::size_t e = 0; e < revoked_.size(); ++e) {
    if (graph.edges()[e].revoked == (revoked_[e] != 0)) continue;
    BinaryWriter revoked;
    revoked.put(static_cast<std::uint32_t>(e));
    revoked.put(static_cast<std::uint8_t>(graph.edges()[e].revoked));
    putEntry(out, kRevoked, revoked.bytes());
  }
  // Segments that were found. One that followed and was not found yet is not part of the map.
  const auto isNew = [&](std::size_t id) { return map.in_map[id] != 0 && in_map_[id] == 0; };
  for (std::size_t first = 0, end = 0; first < in_map_.size(); first = end + 1) {
    for (end = first; end < in_map_.size() && isNew(end);) ++end;
    if (end == first) continue;
    BinaryWriter found;
    found.put(static_cast<std::uint32_t>(first));
    found.put(static_cast<std::uint32_t>(end));
    putEntry(out, kInMap, found.bytes());
  }
  if (moved) {
    BinaryWriter poses;
    encodePoses(poses, graph.poses());
    putEntry(out, kPoses, poses.bytes());
  }
  for (const MapView& view : seen) {
    BinaryWriter content;
    encodeView(content, view);
    putEntry(out, kView, content.bytes());
  }
  if (map.edits.revision != edits_) putEntry(out, kEdits, encodeEdits(map));
  if (const std::string state = encodeState(map); state != state_) putEntry(out, kState, state);
  if (out.bytes().empty()) return;
  requireReadable(out.bytes(), map);
  file_.append(recordOf(out.bytes()));
  remember(map);
}

MapJournal::Replayed MapJournal::replay(const std::filesystem::path& file, MapState& map) {
  Replayed replayed;
  try {
    InputFile in(file);
    for (std::string header = in.read(kHeader); !header.empty(); header = in.read(kHeader)) {
      replayed.torn = true;  // until all of the record has been applied
      BinaryReader fields(header);
      if (fields.get<std::uint32_t>() != kMagic) break;
      const auto size = fields.get<std::uint32_t>(), crc = fields.get<std::uint32_t>();
      if (size > kLargestRecord) break;
      const std::string record = in.read(size);
      if (record.size() != size || crc32Of(record) != crc) break;
      applyRecord(record, map, replayed);
      ++replayed.records;
      replayed.torn = false;
    }
  } catch (const DiskError& error) {
    replayed.torn = true;
    replayed.unread = error.what();
  } catch (const std::runtime_error&) {  // a header that is cut off, or an entry that fits no map
    replayed.torn = true;
  }
  return replayed;
}

}  // namespace slam
