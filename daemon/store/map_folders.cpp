// SPDX-License-Identifier: BSD-3-Clause
#include "store/map_folders.hpp"

#include <stdexcept>
#include <vector>

#include "problems/answer.hpp"
#include "problems/answers.hpp"
#include "store/durable_file.hpp"
#include "store/map_store.hpp"

namespace slam {
namespace {

namespace fs = std::filesystem;
const char* const kBefore = ".before";  // no name of a map
const char* const kAside = ".deleted";  // no name of a map: all who list maps pass it over

}  // namespace

fs::path mapFolder(const fs::path& directory, const std::string& name) {
  if (!MapStore::isName(name)) throw CommandRefused({answer::kNoMapName, {}, {name}});
  if (!fs::is_directory(directory / name)) throw CommandRefused({answer::kNoSuchMap, {}, {name}});
  return directory / name;
}

void requireFreeName(const fs::path& directory, const std::string& name) {
  if (!MapStore::isName(name)) throw CommandRefused({answer::kNoMapName, {}, {name}});
  if (name.ends_with(".yaml")) throw CommandRefused({answer::kPlanName, {}, {name}});
  if (fs::exists(fs::symlink_status(directory / name))) throw CommandRefused({answer::kMapExists, {}, {name}});
}

void renameMap(const fs::path& directory, const std::string& from, const std::string& to) {
  const fs::path folder = mapFolder(directory, from);
  requireFreeName(directory, to);
  const FolderLock lock(folder);
  fs::rename(folder, directory / to);
  syncFolder(directory);
}

void removeMap(const fs::path& directory, const std::string& name) {
  const fs::path folder = mapFolder(directory, name);
  const FolderLock lock(folder);
  fs::remove_all(folder);
  syncFolder(directory);
}

void putMapAside(const fs::path& directory, const std::string& name) {
  const fs::path folder = mapFolder(directory, name), aside = directory / kAside;
  const FolderLock lock(folder);
  fs::create_directories(aside);
  // The one before goes when this one is safe.
  if (fs::exists(aside / name)) fs::rename(aside / name, aside / kBefore);
  fs::rename(folder, aside / name);
  syncFolder(aside);
  syncFolder(directory);
  for (const fs::directory_entry& entry : std::vector<fs::directory_entry>(fs::directory_iterator(aside), {}))
    if (entry.path().filename() != name) fs::remove_all(entry.path());
}

std::string restoreMap(const fs::path& directory) {
  std::error_code error;  // of no such folder: then there is none
  for (const fs::directory_entry& entry : fs::directory_iterator(directory / kAside, error)) {
    const std::string name = entry.path().filename();
    if (!MapStore::isName(name) || !entry.is_directory()) continue;
    requireFreeName(directory, name);
    fs::rename(entry.path(), directory / name);
    syncFolder(directory);
    return name;
  }
  throw CommandRefused(answer::kNoneDeleted);
}

}  // namespace slam
