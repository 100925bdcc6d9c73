// SPDX-License-Identifier: BSD-3-Clause
#include "store/map_store.hpp"

#include <algorithm>
#include <cctype>
#include <charconv>
#include <cstdio>
#include <limits>
#include <optional>
#include <stdexcept>
#include <system_error>
#include <tuple>

#include "mapping/map_files.hpp"
#include "slam/map_import.hpp"
#include "store/edit_codec.hpp"
#include "store/map_codec.hpp"
#include "store/map_manifest.hpp"

namespace slam {
namespace {

namespace fs = std::filesystem;
constexpr int kKept = 2;                             // intact generations
constexpr int kHighestGeneration = 999'999'999;      // that numbered() names
constexpr int kMostLeft = 8;                         // unfinished checkpoints that cannot be removed
constexpr std::uint64_t kLongestManifest = 1 << 16;  // [bytes]
const char* const kManifest = "MANIFEST";
const char* const kFiles[] = {"keyframes.bin", "graph.bin", "grid.bin", "state.toml"};
const char* const kDepthFile = "depth.bin";  // a map without a depth camera may lack it
const char* const kTemporary = "writing";
const char* const kJournal = ".journal";

std::string numbered(int generation) {
  char text[16];
  std::snprintf(text, sizeof text, "%06d", generation);
  return text;
}

fs::path journalOf(const fs::path& map, int generation) { return map / (numbered(generation) + kJournal); }

/// The number of a generation by the name that numbered() gives it, and no other; std::nullopt: it is none.
std::optional<int> numberOf(const std::string& name) {
  int number = 0;
  const auto [end, error] = std::from_chars(name.data(), name.data() + name.size(), number);
  const bool whole = error == std::errc{} && end == name.data() + name.size();
  return whole && number > 0 && number <= kHighestGeneration && numbered(number) == name ? std::optional(number)
                                                                                         : std::nullopt;
}

std::optional<int> numberOfJournal(const std::string& name) {
  return name.ends_with(kJournal) ? numberOf(name.substr(0, name.size() - std::string(kJournal).size())) : std::nullopt;
}

bool isFolder(const fs::path& path) {
  std::error_code error;  // of a loop of links, or where nobody may look: it is none that can be used
  return fs::is_directory(path, error);
}

/// Whether anything has this name, also a link to nowhere.
bool isTaken(const fs::path& path) {
  std::error_code error;
  return fs::symlink_status(path, error).type() != fs::file_type::not_found;
}

/// Names in a folder; none where there is no folder. @throws DiskError
std::vector<std::string> namesIn(const fs::path& folder) {
  std::vector<std::string> names;
  std::error_code error;
  fs::directory_iterator entry(folder, error);
  for (; !error && entry != fs::directory_iterator(); entry.increment(error)) {
    names.push_back(entry->path().filename().string());
  }
  if (error && error != std::errc::no_such_file_or_directory && error != std::errc::not_a_directory) {
    throw DiskError(folder.string() + ": cannot read: " + error.message(), error.value());
  }
  return names;
}

/// Generations that a map's folder holds, newest first. @throws DiskError
std::vector<int> generationsOf(const fs::path& map) {
  std::vector<int> generations;
  for (const std::string& name : namesIn(map)) {
    if (const auto number = numberOf(name); number && isFolder(map / name)) generations.push_back(*number);
  }
  std::sort(generations.rbegin(), generations.rend());
  return generations;
}

/// Numbers of the journals of a map, oldest first. @throws DiskError
std::vector<int> journalsOf(const fs::path& map) {
  std::vector<int> journals;
  for (const std::string& name : namesIn(map)) {
    if (const auto number = numberOfJournal(name)) journals.push_back(*number);
  }
  std::sort(journals.begin(), journals.end());
  return journals;
}

MapManifest readManifest(const fs::path& generation) {
  const fs::path file = generation / kManifest;
  const std::string text = readFile(file, kLongestManifest);
  try {
    return decodeManifest(text);
  } catch (const NewerMap& error) {
    throw NewerMap(file.string() + ": " + error.what(), error.order);
  } catch (const std::runtime_error& error) {
    throw std::runtime_error(file.string() + ": " + error.what());
  }
}

std::string readChecked(const fs::path& generation, const MapManifest& manifest, const std::string& name) {
  const fs::path file = generation / name;
  const auto listed = manifest.files.find(name);
  if (listed == manifest.files.end()) throw std::runtime_error(file.string() + ": is not in the manifest");
  std::string content = readFile(file, listed->second.size);
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

/// By which the maps of a folder are put in order.
struct Standing {
  std::int64_t order = 0;
  fs::file_time_type written = fs::file_time_type::min();  // of what its newest generation and journals are
  int generation = 0;                                      // newest one whose manifest can be read
};

/// std::nullopt: no manifest of it can be read. @throws DiskError
std::optional<Standing> standingOf(const fs::path& map) {
  std::optional<Standing> standing;
  for (const int generation : generationsOf(map)) {
    try {
      standing = {.order = readManifest(map / numbered(generation)).order, .generation = generation};
    } catch (const NewerMap& newer) {
      standing = {.order = newer.order, .generation = generation};
    } catch (const std::runtime_error&) {
      continue;
    }
    break;
  }
  for (const std::string& name : namesIn(map)) {
    std::error_code error;  // of a link to nowhere
    if (!standing || (!numberOf(name) && !numberOfJournal(name))) continue;
    if (const auto time = fs::last_write_time(map / name, error); !error) {
      standing->written = std::max(standing->written, time);
    }
  }
  return standing;
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

/// A map as it was read, before what its grid lacks is drawn.
struct ReadMap {
  LoadedMap loaded;
  MapManifest manifest;       // of its checkpoint
  bool redraw = false;        // the grid is damaged, or keyframes that it shows moved
  std::vector<MapView> seen;  // and not in the grid
};

/// One generation without its journal. A damaged grid is to be drawn anew: the keyframes hold what it showed.
/// @param strict throws also where the map can do without a file
ReadMap readGeneration(const fs::path& generation, const OccupancyGridConfig& config, bool strict = false) {
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
    if (strict) throw;
    read.loaded.remarks.push_back(std::string(error.what()) + "; the grid is drawn anew from the keyframes");
    read.redraw = true;
    map.grid = OccupancyGrid(config);
  }
  if (read.manifest.files.contains(kDepthFile)) {
    try {
      decode(kDepthFile, [&](const std::string& bytes) { decodeDepth(bytes, map); });
    } catch (const std::runtime_error& error) {
      if (strict) throw;
      read.loaded.remarks.push_back(std::string(error.what()) + "; what the depth camera saw is lost");
    }
  }
  if (read.manifest.files.contains(kEditsFile))
    decode(kEditsFile, [&](const std::string& bytes) { decodeEdits(bytes, map); });
  return read;
}

/// Journals lead from a generation to the next one, and on: also past a damaged one.
void readJournals(const fs::path& folder, ReadMap& read) {
  for (const int number : journalsOf(folder)) {
    if (number < read.loaded.generation) continue;
    const auto replayed = MapJournal::replay(journalOf(folder, number), read.loaded.state);
    read.redraw |= replayed.moved;
    read.seen.insert(read.seen.end(), replayed.seen.begin(), replayed.seen.end());
    if (!replayed.torn) continue;
    const std::string records = std::to_string(replayed.records);
    read.loaded.remarks.push_back(replayed.unread.empty()
                                      ? journalOf(folder, number).string() + ": cut off behind record " + records +
                                            "; used all before it"
                                      : replayed.unread + "; used the " + records + " records before that");
    // Behind damage nothing can follow. What is no journal at all is in nobody's way.
    if (replayed.unread.empty()) return;
  }
}

/// Whether what was written is what can be read: a map of numbers that no reader takes would bury the one before it.
/// @throws UnreadableMap, or DiskError
void requireReadable(const fs::path& generation) {
  try {
    readGeneration(generation, {}, true);
  } catch (const DiskError&) {
    throw;
  } catch (const std::runtime_error& error) {
    throw UnreadableMap(std::string("what was written could not be read back: ") + error.what());
  }
}

/// The generation before leads up to the next one by its journal, where that can hold what has changed.
void leadUpTo(const MapState& map, std::span<const MapView> seen, MapJournal& journal) {
  try {
    journal.append(map, seen);
  } catch (const DiskError&) {
    throw;
  } catch (const std::runtime_error&) {  // the next generation holds it, and this journal ends before it
  }
  journal.sync();
}

/// A new folder for what is not finished. What is left of another one, and cannot be removed, keeps its name.
fs::path makeTemporary(const fs::path& map) {
  for (int i = 1;; ++i) {
    const fs::path folder = map / (i == 1 ? kTemporary : kTemporary + ("-" + std::to_string(i)));
    std::error_code error;
    fs::remove_all(folder, error);
    if (isTaken(folder) && i < kMostLeft) continue;
    fs::create_directory(folder, error);
    if (error) throw DiskError(folder.string() + ": cannot make: " + error.message(), error.value());
    return folder;
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
  const auto generations = generationsOf(directory_);
  const auto standing = standingOf(directory_);
  if (!generations.empty()) generation_ = standing ? standing->generation : generations.front();
}

/// The present order where no other map has as high a one, else one above them.
std::int64_t MapStore::orderOfLast() const {
  const auto orderOf = [](const fs::path& map) {
    try {
      const auto standing = standingOf(map);
      return standing ? standing->order : 0;
    } catch (const DiskError&) {  // where nobody may look there is no map to go on in
      return std::int64_t{0};
    }
  };
  std::int64_t others = 0;
  const fs::path store = directory_.parent_path();
  for (const std::string& name : names(store)) {
    if (name != name_) others = std::max(others, orderOf(store / name));
  }
  constexpr auto kHighest = std::numeric_limits<std::int64_t>::max() - 1;
  return std::max(orderOf(directory_), std::min(others, kHighest) + 1);
}

/// The one behind the newest, and behind what lies in its place.
int MapStore::numberOfNext() const {
  int next = generation_ + 1;
  while (next <= kHighestGeneration && (isTaken(directory_ / numbered(next)) || isTaken(journalOf(directory_, next)))) {
    ++next;
  }
  if (next > kHighestGeneration) {
    throw std::runtime_error(directory_.string() + ": no number is left behind generation " +
                             std::to_string(generation_) + "; move it away");
  }
  return next;
}

void MapStore::checkpoint(const MapState& map, std::span<const MapView> seen) { write(map, seen, orderOfLast()); }

void MapStore::write(const MapState& map, std::span<const MapView> seen, std::int64_t order) {
  const int next = numberOfNext();
  const fs::path temporary = makeTemporary(directory_);
  try {
    MapManifest manifest{.utime = map.utime, .order = order, .keyframes = map.keyframes.size(), .files = {}};
    const auto put = [&](const char* name, const std::string& content) {
      writeDurably(temporary / name, content);
      manifest.files[name] = {content.size(), crc32Of(content)};
    };
    put(kFiles[0], encodeKeyframes(map));
    put(kFiles[1], encodeEdges(map));
    put(kFiles[2], encodeGrid(map.grid));
    put(kFiles[3], encodeState(map));
    put(kDepthFile, encodeDepth(map));
    if (!map.edits.empty()) put(kEditsFile, encodeEdits(map));
    writeDurably(temporary / kManifest, encodeManifest(manifest));
    syncFolder(temporary);
    requireReadable(temporary);
    if (journal_) leadUpTo(map, seen, *journal_);
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
  if (first_written_ == 0) first_written_ = generation_;
  syncFolder(directory_);
  removeOld();
}

/// What is older than the generations that can be fallen back to. What cannot be removed takes room, and no more.
void MapStore::removeOld() {
  leftover_.clear();
  try {
    int kept = 0, oldest = 0;
    for (const int old : generationsOf(directory_)) {
      if (old > generation_ || kept == kKept) continue;
      if (old < first_written_ && !isIntact(directory_ / numbered(old))) continue;
      ++kept;
      oldest = old;
    }
    if (kept < kKept) return;
    for (const std::string& name : namesIn(directory_)) {
      const auto number = numberOf(name), of_journal = numberOfJournal(name);
      if ((number ? *number : of_journal ? *of_journal : oldest) >= oldest) continue;
      std::error_code error;
      fs::remove_all(directory_ / name, error);
      if (error) leftover_ = (directory_ / name).string() + ": cannot remove: " + error.message();
    }
  } catch (const DiskError& error) {
    leftover_ = error.what();
  }
}

void MapStore::append(const MapState& map, std::span<const MapView> seen) {
  if (journal_) journal_->append(map, seen);
}

void MapStore::sync() {
  if (journal_) journal_->sync();
}

LoadedMap MapStore::load(const fs::path& directory, const std::string& name, const OccupancyGridConfig& config) {
  ReadMap read = readNewest(directory / name, config);
  MapState& map = read.loaded.state;
  if (read.redraw) {
    map.grid = drawGrid(map, config);
    map.grid_keyframes = map.keyframes.size();
  } else {
    FreeCells free(drawingOf(map).free, map.grid.resolution());
    for (const MapView& view : read.seen) {
      map.grid.add(view.T_map_base() * view.view->T_base_depth, *view.view);
      free.apply(map.grid, map.grid.touched());
    }
  }
  return std::move(read.loaded);
}

std::vector<std::string> MapStore::names(const fs::path& directory) {
  std::vector<std::string> maps = namesIn(directory);
  std::erase_if(maps, [&](const std::string& name) { return !isName(name) || !isFolder(directory / name); });
  std::sort(maps.begin(), maps.end());
  return maps;
}

std::vector<MapSummary> MapStore::list(const fs::path& directory) {
  std::vector<MapSummary> maps;
  for (const std::string& name : names(directory)) {
    MapSummary summary;
    summary.name = name;
    try {
      const auto generations = generationsOf(directory / name);
      if (generations.empty()) continue;
      summary.newest = generations.front();
      const ReadMap read = readNewest(directory / name, {});
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
    maps.push_back(std::move(summary));
  }
  return maps;
}

std::optional<std::string> MapStore::newest(const fs::path& directory, std::vector<std::string>* passed_over) {
  using Rank = std::tuple<std::int64_t, fs::file_time_type, std::string>;
  std::optional<Rank> highest;
  const auto passOver = [&](const std::string& why) {
    if (passed_over != nullptr) passed_over->push_back(why);
  };
  for (const std::string& name : names(directory)) {
    const fs::path map = directory / name;
    try {
      if (const auto standing = standingOf(map)) {
        highest = std::max(highest, std::optional(Rank(standing->order, standing->written, name)));
      } else if (!generationsOf(map).empty()) {
        passOver(map.string() + ": no generation in it has a manifest that can be read");
      }
    } catch (const DiskError& error) {
      passOver(error.what());
    }
  }
  return highest ? std::optional(std::get<std::string>(*highest)) : std::nullopt;
}

LoadedMap openMap(const fs::path& path, const OccupancyGridConfig& grid) {
  if (path.extension() == ".yaml") return {importMap(readMapFiles(path)), 0, {}};
  const fs::path folder = fs::absolute(path).lexically_normal();
  return folder.has_filename()
             ? MapStore::load(folder.parent_path(), folder.filename(), grid)
             : MapStore::load(folder.parent_path().parent_path(), folder.parent_path().filename(), grid);
}

}  // namespace slam
