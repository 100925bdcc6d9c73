// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <filesystem>
#include <map>
#include <minizip/unzip.h>
#include <string>

namespace slam::test {

/// All entries of a zip file, by their names; empty where it is none.
inline std::map<std::string, std::string> unzipped(const std::filesystem::path& file) {
  std::map<std::string, std::string> entries;
  unzFile zip = unzOpen64(file.c_str());
  if (zip == nullptr) return entries;
  for (int result = unzGoToFirstFile(zip); result == UNZ_OK; result = unzGoToNextFile(zip)) {
    char name[256] = "";
    unz_file_info64 info{};
    unzGetCurrentFileInfo64(zip, &info, name, sizeof name, nullptr, 0, nullptr, 0);
    unzOpenCurrentFile(zip);
    std::string content(info.uncompressed_size, '\0');
    content.resize(static_cast<std::size_t>(
        std::max(0, unzReadCurrentFile(zip, content.data(), static_cast<unsigned>(content.size())))));
    unzCloseCurrentFile(zip);
    entries[name] = content;
  }
  unzClose(zip);
  return entries;
}

}  // namespace slam::test
