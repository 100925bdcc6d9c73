// SPDX-License-Identifier: BSD-3-Clause
#include "store/map_store.hpp"

#include <algorithm>
#include <cctype>
#include <cstdio>
#include <map>
#include <stdexcept>

#include "mapping/map_files.hpp"
#include "slam/map_import.hpp"
#include "store/map_codec.hpp"
#include "store/map_manifest.hpp"

namespace slam {
namespace {

namespace fs = std::filesystem;
constexpr int kKept = 2;  // intact generations
const char* const kFiles[] = {"keyframes.bin", "graph.bin", "grid.bin", "state.toml"};
const char* const kDepthFile = "depth.bin";  // a map without a depth camera may lack it
const char* const kTemporary = "writing";

std::string numbered(int generation) {
  char text[16];
  std::snprintf(text, sizeof text, "%06d", generation);
  return text;
}

fs::path journalOf(const fs::path& map, int generation) { return map / (numbered(generation) + ".journal"); }

/// Generations that a map's folder holds, newest first.
std::vector<int> generationsOf(const fs::path& map) {
  std::vector<int> generations;
  std::error_code error;
  for (const auto& entry : fs::directory_iterator(map, error)) {
    const std::string name = entry.path().filename().string();
    const bool number = !name.empty() && name.size() <= 9 &&
                        std::all_of(name.begin(), name.end(), [](unsigned char c) { return std::isdigit(c); });
    if (number && entry.is_directory()) generations.push_back(std::stoi(name));
  }
  std::sort(generations.rbegin(), generations.rend());
  return generations;
}

MapManifest manifestOf(const MapState& map, const std::map<std::string, std::string>& files) {
  MapManifest manifest{.utime = map.utime, .keyframes = map.keyframes.size(), .files = {}};
  for (const auto& [name, content] : files) manifest.files[name] = {content.size(), crc32Of(content)};
  return manifest;
}

MapManifest readManifest(const fs::path& generation) {
  const fs::path file = generation / "MANIFEST";
  const std::string text = readFile(file);
  try {
    return decodeManifest(text);
  } catch (const NewerMap& error) {
    throw NewerMap(file.string() + ": " + error.what());
  } catch (const std::runtime_error& error) {
    throw std::runtime_error(file.string() + ": " + error.what());
  }
}

std::string readChecked(const fs::path& generation, const MapManifest& manifest, const std::string& name) {
  const fs::path file = generation / name;
  const auto listed = manifest.files.find(name);
  if (listed == manifest.files.end()) throw std::runtime_error(file.string() + ": is not in the manifest");
  std::string content = readFile(file);
  if (listed->second != MapManifest::File{content.size(), crc32Of(content)}) {
    throw std::runtime_error(file.string() + ": is damaged (its CRC differs)");
  }
  return content;
}

/// Whether all that its manifest lists is as it was written.
bool isIntact(const fs::path& generation) {
  try {
    const MapManifest manifest = readManifest(generation);
    for (const auto& listed : manifest.files) readChecked(generation, manifest, listed.first);
    return true;
  } catch (const std::runtime_error&) {
    return false;
  }
}

/// Reads one file of a generation; an error names the file.
template <typename Decode>
void decodeFile(const fs::path& generation, const MapManifest& manifest, const char* name, Decode&& decode) {
  const std::string content = readChecked(generation, manifest, name);
  try {
    decode(content);
  } catch (const std::runtime_error& error) {
    throw std::runtime_error((generation / name).string() + ": " + error.what());
  }
}

/// Draws all keyframes of the map, in place of a grid that cannot be used.
OccupancyGrid drawGrid(const MapState& map, const OccupancyGridConfig& config) {
  OccupancyGrid grid(config);
  for (int id = 0; id < map.keyframes.size(); ++id) {
    const StoredScan& scan = *map.keyframes.scan(id);
    if (map.in_map[static_cast<std::size_t>(id)] != 0) grid.add(map.keyframes.pose(id), scan.T_base_lidar, scan.points);
  }
  for (const MapView& view : viewsOf(map)) grid.add(view.T_map_base() * view.view->T_base_depth, *view.view);
  return grid;
}

/// A map as it was read, before what its grid lacks is drawn.
struct ReadMap {
  LoadedMap loaded;
  MapManifest manifest;       // of its checkpoint
  bool redraw = false;        // the grid is damaged, or keyframes that it shows moved
  std::vector<MapView> seen;  // and not in the grid
};

/// One generation without its journal. A damaged grid is to be drawn anew: the keyframes hold what it showed.
ReadMap readGeneration(const fs::path& generation, const OccupancyGridConfig& config) {
  ReadMap read;
  read.manifest = readManifest(generation);
  MapState& map = read.loaded.state;
  const auto decode = [&](const char* name, const auto& decoder) {
    decodeFile(generation, read.manifest, name, decoder);
  };
  decode(kFiles[0], [&](const std::string& bytes) { decodeKeyframes(bytes, map); });
  decode(kFiles[1], [&](const std::string& bytes) { decodeEdges(bytes, map); });
  decode(kFiles[3], [&](const std::string& bytes) { decodeState(bytes, map); });
  try {
    decode(kFiles[2], [&](const std::string& bytes) { map.grid = decodeGrid(bytes, config); });
  } catch (const std::runtime_error& error) {
    read.loaded.remarks.push_back(std::string(error.what()) + "; the grid is drawn anew from the keyframes");
    read.redraw = true;
    map.grid = OccupancyGrid(config);
  }
  if (read.manifest.files.contains(kDepthFile)) {
    try {
      decode(kDepthFile, [&](const std::string& bytes) { decodeDepth(bytes, map); });
    } catch (const std::runtime_error& error) {
      read.loaded.remarks.push_back(std::string(error.what()) + "; what the depth camera saw is lost");
    }
  }
  return read;
}

/// Journals lead from a generation to the next one, and on: also past a damaged one.
void readJournals(const fs::path& folder, ReadMap& read) {
  for (int next = read.loaded.generation; fs::exists(journalOf(folder, next)); ++next) {
    const auto replayed = MapJournal::replay(journalOf(folder, next), read.loaded.state);
    read.redraw |= replayed.moved;
    read.seen.insert(read.seen.end(), replayed.seen.begin(), replayed.seen.end());
    if (!replayed.torn) continue;
    read.loaded.remarks.push_back(journalOf(folder, next).string() + ": cut off behind record " +
                                  std::to_string(replayed.records) + "; used all before it");
    return;
  }
}

/// The newest state of a map that can be read. @throws what MapStore::load() does
ReadMap readNewest(const fs::path& folder, const OccupancyGridConfig& config) {
  const auto generations = generationsOf(folder);
  if (generations.empty()) throw std::runtime_error(folder.string() + ": holds no map");
  std::string first_problem;
  for (const int generation : generations) {
    try {
      ReadMap read = readGeneration(folder / numbered(generation), config);
      read.loaded.generation = generation;
      if (!first_problem.empty()) {
        read.loaded.remarks.insert(read.loaded.remarks.begin(),
                                   first_problem + "; used generation " + std::to_string(generation) + " instead");
      }
      readJournals(folder, read);
      return read;
    } catch (const NewerMap&) {
      throw;
    } catch (const std::runtime_error& error) {
      if (first_problem.empty()) first_problem = error.what();
    }
  }
  throw std::runtime_error(first_problem + "; no generation of the map is intact");
}

}  // namespace

bool MapStore::isName(const std::string& name) {
  return !name.empty() && name.size() <= 100 && name.front() != '.' &&
         std::all_of(name.begin(), name.end(),
                     [](unsigned char c) { return std::isalnum(c) || c == '-' || c == '_' || c == '.'; });
}

MapStore::MapStore(fs::path directory, std::string name)
    : directory_(std::move(directory) / name), name_(std::move(name)) {
  if (!isName(name_)) throw std::runtime_error("\"" + name_ + "\" is no name of a map; use letters, digits, - and _");
  fs::create_directories(directory_);
  for (const int generation : generationsOf(directory_)) generation_ = std::max(generation_, generation);
}

void MapStore::checkpoint(const MapState& map, std::span<const MapView> seen) {
  const std::map<std::string, std::string> files = {{kFiles[0], encodeKeyframes(map)},
                                                    {kFiles[1], encodeEdges(map)},
                                                    {kFiles[2], encodeGrid(map.grid)},
                                                    {kFiles[3], encodeState(map)},
                                                    {kDepthFile, encodeDepth(map)}};
  const fs::path temporary = directory_ / kTemporary;
  const int next = generation_ + 1;
  try {
    fs::remove_all(temporary);
    fs::create_directory(temporary);
    for (const auto& [name, content] : files) writeDurably(temporary / name, content);
    writeDurably(temporary / "MANIFEST", encodeManifest(manifestOf(map, files)));
    syncFolder(temporary);
    if (journal_) journal_->append(map, seen), journal_->sync();  // the generation before leads up to this one
    // Before the generation is there: whatever fails up to then, the old journal goes on.
    auto journal = std::make_unique<MapJournal>(journalOf(directory_, next), map);
    journal->sync();
    fs::rename(temporary, directory_ / numbered(next));
    journal_ = std::move(journal);
  } catch (const std::exception&) {
    std::error_code ignored;  // on a full disk the journal needs the room
    fs::remove_all(temporary, ignored);
    fs::remove(journalOf(directory_, next), ignored);
    throw;
  }
  generation_ = next;
  syncFolder(directory_);
  if (first_written_ == 0) first_written_ = generation_;
  int kept = 0;  // that can be fallen back to
  for (const int old : generationsOf(directory_)) {
    const fs::path generation = directory_ / numbered(old);
    if (kept == kKept) {
      fs::remove_all(generation);
      fs::remove(journalOf(directory_, old));
    } else if (old >= first_written_ || isIntact(generation)) {
      ++kept;
    }
  }
}

void MapStore::append(const MapState& map, std::span<const MapView> seen) {
  if (journal_) journal_->append(map, seen);
}

void MapStore::sync() {
  if (journal_) journal_->sync();
}

void MapStore::touch() {
  std::error_code ignored;  // there is no journal before the first checkpoint
  fs::last_write_time(journalOf(directory_, generation_), fs::file_time_type::clock::now(), ignored);
}

LoadedMap MapStore::load(const fs::path& directory, const std::string& name, const OccupancyGridConfig& config) {
  ReadMap read = readNewest(directory / name, config);
  MapState& map = read.loaded.state;
  if (read.redraw) {
    map.grid = drawGrid(map, config);
    map.grid_keyframes = map.keyframes.size();
  } else {
    for (const MapView& view : read.seen) map.grid.add(view.T_map_base() * view.view->T_base_depth, *view.view);
  }
  return std::move(read.loaded);
}

std::vector<MapSummary> MapStore::list(const fs::path& directory) {
  std::vector<MapSummary> maps;
  std::error_code error;
  for (const auto& entry : fs::directory_iterator(directory, error)) {
    const std::string name = entry.path().filename().string();
    const auto generations = generationsOf(entry.path());
    if (!entry.is_directory() || !isName(name) || generations.empty()) continue;
    MapSummary& summary = maps.emplace_back();
    summary.name = name;
    summary.newest = generations.front();
    try {
      const ReadMap read = readNewest(entry.path(), {});
      summary.generation = read.loaded.generation;
      summary.keyframes = read.manifest.keyframes;
      summary.utime = read.manifest.utime;
      for (const std::string& remark : read.loaded.remarks) {
        summary.problem += (summary.problem.empty() ? "" : "; ") + remark;
      }
    } catch (const NewerMap& newer) {
      summary.newer = true;
      summary.problem = newer.what();
    } catch (const std::runtime_error& damage) {
      summary.problem = damage.what();
    }
  }
  std::sort(maps.begin(), maps.end(), [](const MapSummary& a, const MapSummary& b) { return a.name < b.name; });
  return maps;
}

std::optional<std::string> MapStore::newest(const fs::path& directory) {
  // By the file system's clock, which also counts journals: the robot's own may have been wrong.
  std::optional<std::string> newest;
  fs::file_time_type latest{};
  std::error_code error;
  for (const auto& map : fs::directory_iterator(directory, error)) {
    if (!map.is_directory() || !isName(map.path().filename().string()) || generationsOf(map.path()).empty()) continue;
    for (const auto& entry : fs::directory_iterator(map.path(), error)) {
      const auto written = entry.last_write_time(error);
      if (newest && written <= latest) continue;
      newest = map.path().filename().string();
      latest = written;
    }
  }
  return newest;
}

LoadedMap openMap(const fs::path& path, const OccupancyGridConfig& grid) {
  if (path.extension() == ".yaml") return {importMap(readMapFiles(path)), 0, {}};
  const fs::path folder = fs::absolute(path).lexically_normal();
  return folder.has_filename()
             ? MapStore::load(folder.parent_path(), folder.filename(), grid)
             : MapStore::load(folder.parent_path().parent_path(), folder.parent_path().filename(), grid);
}

}  // namespace slam
