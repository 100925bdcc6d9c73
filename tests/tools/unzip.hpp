// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <archive.h>
#include <archive_entry.h>
#include <filesystem>
#include <map>
#include <memory>
#include <string>

namespace slam::test {

/// All entries of a zip file, by their names; empty where it is none.
inline std::map<std::string, std::string> unzipped(const std::filesystem::path& file) {
  std::map<std::string, std::string> entries;
  const std::unique_ptr<archive, int (*)(archive*)> zip(archive_read_new(), &archive_read_free);
  archive_read_support_format_zip_seekable(zip.get());  // by its table of entries, as programs of desktops do
  if (archive_read_open_filename(zip.get(), file.c_str(), 1 << 16) != ARCHIVE_OK) return entries;
  for (archive_entry* entry = nullptr; archive_read_next_header(zip.get(), &entry) == ARCHIVE_OK;) {
    std::string content(static_cast<std::size_t>(archive_entry_size(entry)), '\0');
    if (archive_read_data(zip.get(), content.data(), content.size()) != static_cast<la_ssize_t>(content.size()))
      content = "damaged";
    entries[archive_entry_pathname(entry)] = content;
  }
  return entries;
}

}  // namespace slam::test
