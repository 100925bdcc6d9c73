// SPDX-License-Identifier: BSD-3-Clause
#include "store/map_journal.hpp"

#include <algorithm>

#include "store/map_codec.hpp"

namespace slam {
namespace {

enum Record : std::uint8_t { kNode = 1, kEdge = 2, kPoses = 3, kInMap = 4, kRevoked = 5, kState = 6 };
constexpr std::uint32_t kMagic = 0x4A4D4C53;  // "SLMJ"

void putRecord(BinaryWriter& out, Record type, const std::string& payload) {
  BinaryWriter record;
  record.put(static_cast<std::uint8_t>(type));
  record.putBytes(payload);
  out.put(kMagic);
  out.put(static_cast<std::uint32_t>(record.bytes().size()));
  out.put(crc32Of(record.bytes()));
  out.putBytes(record.bytes());
}

void applyRecord(std::string_view bytes, MapState& map, bool& moved) {
  BinaryReader in(bytes);
  switch (in.get<std::uint8_t>()) {
    case kNode:
      decodeNode(in, map);
      break;
    case kEdge:
      decodeEdge(in, map);
      break;
    case kPoses:
      decodePoses(in, map);
      moved = true;
      break;
    case kInMap: {
      const auto first = in.get<std::uint32_t>();
      if (first > map.in_map.size()) throw std::runtime_error("names a keyframe that is not there");
      std::fill(map.in_map.begin() + first, map.in_map.end(), 1);
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
    case kState:
      decodeState(in.getBytes(bytes.size() - 1), map);
      break;
    default:
      throw std::runtime_error("holds a record of an unknown kind");
  }
}

}  // namespace

MapJournal::MapJournal(const std::filesystem::path& file, const MapState& known) : file_(file, 0) { remember(known); }

void MapJournal::remember(const MapState& map) {
  const auto poses = map.keyframes.graph().poses();
  poses_.assign(poses.begin(), poses.end());
  in_map_ = map.in_map;
  revoked_.clear();
  for (const Edge& edge : map.keyframes.graph().edges()) revoked_.push_back(edge.revoked);
  state_ = encodeState(map);
}

void MapJournal::append(const MapState& map) {
  BinaryWriter out;
  const PoseGraph& graph = map.keyframes.graph();
  const bool moved = !std::equal(poses_.begin(), poses_.end(), graph.poses().begin());
  for (int id = static_cast<int>(poses_.size()); id < graph.size(); ++id) {
    BinaryWriter node;
    encodeNode(node, *map.keyframes.scan(id), graph.pose(id), map.in_map[static_cast<std::size_t>(id)] != 0);
    putRecord(out, kNode, node.bytes());
  }
  for (std::size_t e = revoked_.size(); e < graph.edges().size(); ++e) {
    BinaryWriter edge;
    encodeEdge(edge, graph.edges()[e]);
    putRecord(out, kEdge, edge.bytes());
  }
  for (std::size_t e = 0; e < revoked_.size(); ++e) {
    if (graph.edges()[e].revoked == (revoked_[e] != 0)) continue;
    BinaryWriter revoked;
    revoked.put(static_cast<std::uint32_t>(e));
    revoked.put(static_cast<std::uint8_t>(graph.edges()[e].revoked));
    putRecord(out, kRevoked, revoked.bytes());
  }
  // A segment that was found: from its first keyframe on all are part of the map.
  const auto found = std::mismatch(in_map_.begin(), in_map_.end(), map.in_map.begin()).first;
  if (found != in_map_.end()) {
    BinaryWriter first;
    first.put(static_cast<std::uint32_t>(found - in_map_.begin()));
    putRecord(out, kInMap, first.bytes());
  }
  if (moved) {
    BinaryWriter poses;
    encodePoses(poses, graph.poses());
    putRecord(out, kPoses, poses.bytes());
  }
  if (const std::string state = encodeState(map); state != state_) putRecord(out, kState, state);
  if (out.bytes().empty()) return;
  file_.append(out.bytes());
  remember(map);
}

MapJournal::Replayed MapJournal::replay(const std::filesystem::path& file, MapState& map) {
  Replayed replayed;
  const std::string content = readFile(file);
  BinaryReader in(content);
  while (!in.atEnd()) {
    try {
      if (in.get<std::uint32_t>() != kMagic) break;
      const auto size = in.get<std::uint32_t>();
      const auto crc = in.get<std::uint32_t>();
      const std::string_view record = in.getBytes(size);
      if (crc32Of(record) != crc) break;
      applyRecord(record, map, replayed.moved);
    } catch (const std::runtime_error&) {
      break;
    }
    ++replayed.records;
    if (in.atEnd()) return replayed;
  }
  replayed.torn = !content.empty();
  return replayed;
}

}  // namespace slam
