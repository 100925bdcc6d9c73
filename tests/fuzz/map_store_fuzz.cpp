// SPDX-License-Identifier: BSD-3-Clause
// The input is a byte that chooses a part of a stored map, then that part. A map that decodes is then run. What lies
// compressed or behind a CRC in a file is compressed and sealed here, so that mutations reach what is behind them; the
// raw forms are fuzzed as well.
#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>
#include <zlib.h>

#include "fuzz/fuzzing.hpp"
#include "fuzz/memory_file.hpp"
#include "slam/pipeline.hpp"
#include "store/durable_file.hpp"
#include "store/edit_codec.hpp"
#include "store/map_codec.hpp"
#include "store/map_journal.hpp"
#include "store/map_manifest.hpp"
#include "support/stored_map.hpp"

namespace slam {
namespace {

enum Part : std::uint8_t {
  kKeyframes,
  kEdges,
  kPoses,
  kGrid,
  kRawGrid,
  kDepth,
  kRawDepth,
  kState,
  kJournal,
  kRawJournal,
  kManifest,
  kRawManifest,
  kEdits,
  kParts
};

constexpr int kKeyframesKnown = 5;
constexpr int kMostTiles = 8;

MapState knownMap() {
  static const test::ChangingMap known(kKeyframesKnown);
  return known.copy();
}

using fuzz::textOf;

/// A layer as the store writes it; each tile of three numbers: where it is and what all of its cells say.
std::string layerOf(fuzz::Input& input, double resolution) {
  BinaryWriter tiles;
  for (int i = 0; i < kMostTiles && !input.atEnd(); ++i) {
    tiles.put(input.take<std::int32_t>());
    tiles.put(input.take<std::int32_t>());
    const auto log_odds = input.take<LogOdds>();
    for (int cell = 0; cell < OccupancyGrid::kTileSide * OccupancyGrid::kTileSide; ++cell) tiles.put(log_odds);
  }
  uLongf size = ::compressBound(tiles.bytes().size());
  std::string packed(size, '\0');
  FUZZ_CHECK(::compress2(reinterpret_cast<Bytef*>(packed.data()), &size,
                         reinterpret_cast<const Bytef*>(tiles.bytes().data()), tiles.bytes().size(), 1) == Z_OK);
  packed.resize(size);
  BinaryWriter layer;
  layer.put(resolution);
  layer.put(static_cast<std::uint64_t>(tiles.bytes().size()));
  layer.putBytes(packed);
  return layer.take();
}

/// Keyframes, edges and state, written and read.
MapState throughFiles(const MapState& map) {
  MapState again;
  decodeKeyframes(encodeKeyframes(map), again);
  decodeEdges(encodeEdges(map), again);
  decodeState(encodeState(map), again);
  decodeEdits(encodeEdits(map), again);
  return again;
}

/// A turn of the lidar in a room 4 m wide.
LaserScan someScan() {
  constexpr int kBeams = 90;
  LaserScan scan;
  scan.stamp = Timestamp(std::chrono::seconds(1000));
  for (int i = 0; i < kBeams; ++i) {
    const float bearing = 6.28F * static_cast<float>(i) / kBeams;
    const float range = 2.0F / std::max(std::abs(std::cos(bearing)), std::abs(std::sin(bearing)));
    scan.push({range, bearing, 0.0F, 0.0F});
  }
  return scan;
}

/// Goes on in a map as slamd does with what it has read: front end and back end begin in it and take a scan; the mapper
/// draws it. What can be read can be run.
void run(const MapState& map) {
  static const LaserScan scan = someScan();
  Pipeline pipeline({.front_end = {}, .back_end = {}, .map = test::smallGrid()}, map);
  pipeline.add(scan);
  FUZZ_CHECK(pipeline.backEnd().keyframes().size() >= map.keyframes.size());
  pipeline.drawn();
}

void checkMap(const MapState& map) {
  FUZZ_CHECK(map.in_map.size() == static_cast<std::size_t>(map.keyframes.size()));
  FUZZ_CHECK_NO_THROW(test::differenceOf(map, throughFiles(map)).empty());
  FUZZ_CHECK_NO_THROW((run(map), true));
}

void checkGrid(const std::string& bytes) {
  const OccupancyGrid grid = decodeGrid(bytes, test::smallGrid());
  const std::string written = encodeGrid(grid);
  FUZZ_CHECK_NO_THROW(encodeGrid(decodeGrid(written, test::smallGrid())) == written);
}

void checkDepth(const std::string& bytes) {
  MapState map = knownMap(), again = knownMap();
  decodeDepth(bytes, map);
  const std::string written = encodeDepth(map);
  FUZZ_CHECK_NO_THROW((decodeDepth(written, again), encodeDepth(again)) == written);
}

void checkJournal(const std::string& content) {
  static const fuzz::MemoryFile file;
  file.write(content);
  MapState map = knownMap();
  const MapJournal::Replayed replayed = MapJournal::replay(file.path(), map);
  FUZZ_CHECK(replayed.records >= 0 && static_cast<std::size_t>(replayed.records) * 12 <= content.size());
  FUZZ_CHECK(map.keyframes.size() >= kKeyframesKnown);
  FUZZ_CHECK(map.views.size() == replayed.seen.size());
  for (const MapView& view : map.views) FUZZ_CHECK(view.keyframe >= 0 && view.keyframe < map.keyframes.size());
  checkMap(map);
}

/// Two records, each with the entries that the input says.
std::string journalOf(fuzz::Input& input) {
  BinaryWriter journal;
  for (const std::size_t size : {std::size_t{input.take<std::uint8_t>()}, std::size_t{1} << 16}) {
    const std::string entries = textOf(input.takeBytes(size));
    journal.put(std::uint32_t{0x4A4D4C53});
    journal.put(static_cast<std::uint32_t>(entries.size()));
    journal.put(crc32Of(entries));
    journal.putBytes(entries);
  }
  return journal.take();
}

/// What is intact is written as it was read; who says that a newer slamd wrote it has the CRC on its side.
void checkManifest(const std::string& text) {
  const std::size_t seal = text.rfind("crc32 ");
  const bool intact =
      seal != std::string::npos && text.substr(seal) == "crc32 " + std::to_string(crc32Of(text.substr(0, seal))) + "\n";
  try {
    const MapManifest manifest = decodeManifest(text);
    FUZZ_CHECK(intact);
    FUZZ_CHECK_NO_THROW(decodeManifest(encodeManifest(manifest)) == manifest);
  } catch (const NewerMap&) {
    FUZZ_CHECK(intact);
  }
}

void checkPart(Part part, fuzz::Input& input) {
  MapState map;
  if (part != kKeyframes) map = knownMap();
  switch (part) {
    case kKeyframes:
      decodeKeyframes(textOf(input.rest()), map);
      return checkMap(map);
    case kEdges:
      decodeEdges(textOf(input.rest()), map);
      return checkMap(map);
    case kPoses: {
      const std::string bytes = textOf(input.rest());
      BinaryReader in(bytes);
      decodePoses(in, map);
      return checkMap(map);
    }
    case kGrid: {
      const auto resolution = input.take<double>();
      return checkGrid(layerOf(input, resolution));
    }
    case kRawGrid:
      return checkGrid(textOf(input.rest()));
    case kDepth: {
      const std::string views = textOf(input.takeBytes(input.take<std::uint16_t>()));
      return checkDepth(views + layerOf(input, test::smallGrid().resolution));
    }
    case kRawDepth:
      return checkDepth(textOf(input.rest()));
    case kState:
      decodeState(textOf(input.rest()), map);
      return checkMap(map);
    case kJournal:
      return checkJournal(journalOf(input));
    case kManifest: {
      const std::string lines = textOf(input.rest());
      return checkManifest(lines + "crc32 " + std::to_string(crc32Of(lines)) + "\n");
    }
    case kEdits:
      decodeEdits(textOf(input.rest()), map);
      return checkMap(map);
    case kRawManifest:
      return checkManifest(textOf(input.rest()));
    default:
      return checkJournal(textOf(input.rest()));
  }
}

}  // namespace
}  // namespace slam

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  slam::fuzz::Input input({data, size});
  const auto part = static_cast<slam::Part>(input.take<std::uint8_t>() % slam::kParts);
  try {
    slam::checkPart(part, input);
  } catch (const std::runtime_error&) {  // refused
  }
  return 0;
}
