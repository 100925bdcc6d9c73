// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <filesystem>
#include <string>

/// Maps of a store as folders: other names, and none. None of these is about a map that a program writes.
namespace slam {

/// The folder of a map. @throws std::runtime_error where there is none of that name
std::filesystem::path mapFolder(const std::filesystem::path& directory, const std::string& name);
/// @throws std::runtime_error where it is no name of a map, or is taken
void requireFreeName(const std::filesystem::path& directory, const std::string& name);
/// @throws FolderLocked where a program writes the map, std::runtime_error where there is none, or the new name is
/// taken
void renameMap(const std::filesystem::path& directory, const std::string& from, const std::string& to);
/// Removes a map from the disk. @throws as renameMap()
void removeMap(const std::filesystem::path& directory, const std::string& name);
/// Puts a map aside, so that restoreMap() brings it back; what was put aside before is removed from the disk.
/// @throws as renameMap()
void putMapAside(const std::filesystem::path& directory, const std::string& name);
/// Brings back the map that was put aside last. @return its name @throws as renameMap()
std::string restoreMap(const std::filesystem::path& directory);

}  // namespace slam
