// SPDX-License-Identifier: BSD-3-Clause
#include "store/log_folder.hpp"

#include <algorithm>
#include <array>
#include <cctype>
#include <cerrno>
#include <charconv>
#include <cstdio>
#include <cstring>
#include <fstream>
#include <map>
#include <optional>
#include <stdexcept>
#include <utility>
#include <zlib.h>

#include "store/durable_file.hpp"

namespace slam {
namespace {

namespace fs = std::filesystem;
constexpr const char* kPartial = ".part";
constexpr std::uint64_t kLongestMark = 1 << 20;  // [bytes] of a person's words

/// NNNN of a file of a log; std::nullopt for any other name.
std::optional<std::int64_t> numberOf(const std::string& name) {
  std::int64_t number = 0;
  const auto [end, error] = std::from_chars(name.data(), name.data() + name.size(), number);
  const std::string rest(end, name.data() + name.size());
  // The camera's driver puts -2, -3 ... behind a name that is used already.
  const bool images = rest.ends_with(".oni");
  const bool known = rest == ".lcm" || rest == ".lcm.gz" || rest == ".mark" || images;
  return error == std::errc{} && known && std::isdigit(static_cast<unsigned char>(name[0])) ? std::optional(number)
                                                                                            : std::nullopt;
}

fs::path named(const fs::path& run, std::int64_t number, const char* ending) {
  std::array<char, 40> text{};
  std::snprintf(text.data(), text.size(), "%04lld%s", static_cast<long long>(number), ending);
  return run / text.data();
}

void listRun(const fs::path& run, std::vector<LogFile>& files) {
  std::map<std::int64_t, LogFile> logs;
  for (const fs::directory_entry& entry : fs::directory_iterator(run)) {
    const std::string name = entry.path().filename();
    const auto number = numberOf(name);
    std::error_code gone;
    const std::uint64_t bytes = entry.is_regular_file(gone) ? entry.file_size(gone) : 0;
    if (!number || gone) continue;
    if (name.ends_with(".oni")) {
      files.push_back({.path = entry.path(), .number = *number, .bytes = bytes});
      continue;
    }
    LogFile& file = logs[*number];
    file.number = *number;
    file.bytes += bytes;
    file.marked |= name.ends_with(".mark");
    if (name.ends_with(".gz") || (name.ends_with(".lcm") && file.path.empty())) file.path = entry.path();
  }
  for (auto& [number, file] : logs) {
    if (!file.path.empty()) files.push_back(std::move(file));
  }
}

/// An open gzFile that is closed whatever happens.
struct Compressed {
  gzFile file;
  ~Compressed() {
    if (file != nullptr) gzclose(file);
  }
};

}  // namespace

std::vector<LogFile> logFilesIn(const fs::path& folder) {
  std::vector<LogFile> files;
  try {
    listRun(folder, files);
    for (const fs::directory_entry& entry : fs::directory_iterator(folder)) {
      if (entry.is_directory()) listRun(entry.path(), files);
    }
  } catch (const fs::filesystem_error& error) {
    throw std::runtime_error(error.path1().string() + ": cannot read: " + error.code().message());
  }
  std::sort(files.begin(), files.end(), [](const LogFile& a, const LogFile& b) {
    return std::pair(a.number, a.path) < std::pair(b.number, b.path);
  });
  return files;
}

std::vector<fs::path> logPaths(const std::vector<fs::path>& given) {
  std::vector<fs::path> paths;
  for (const fs::path& path : given) {
    if (!fs::is_directory(path)) {
      paths.push_back(path);
      continue;
    }
    const std::size_t before = paths.size();
    for (const LogFile& file : logFilesIn(path)) {
      if (file.isLog()) paths.push_back(file.path);
    }
    if (paths.size() == before) throw std::runtime_error(path.string() + ": no log (NNNN.lcm) in this folder");
  }
  return paths;
}

std::string markOf(const LogFile& file) {
  return file.marked ? readFile(markPath(file.path.parent_path(), file.number), kLongestMark) : "";
}

fs::path logPath(const fs::path& run, std::int64_t number) { return named(run, number, ".lcm"); }

fs::path markPath(const fs::path& run, std::int64_t number) { return named(run, number, ".mark"); }

void removeLog(const LogFile& file) {
  const fs::path run = file.path.parent_path();
  fs::remove(file.path);
  if (!file.isLog()) return;
  fs::remove(logPath(run, file.number));
  fs::remove(markPath(run, file.number));
}

void tidyLogs(const fs::path& folder, const fs::path& present) {
  for (const fs::directory_entry& run : fs::directory_iterator(folder)) {
    if (!run.is_directory()) continue;
    for (const fs::directory_entry& entry : fs::directory_iterator(run.path())) {
      const fs::path& file = entry.path();
      if (file.extension() == kPartial) fs::remove(file);
      if (file.extension() != ".lcm") continue;
      const bool empty = run.path() != present && entry.file_size() == 0;
      if (empty || fs::exists(file.string() + ".gz")) fs::remove(file);
    }
    if (run.path() != present && fs::is_empty(run.path())) fs::remove(run.path());
  }
}

void compressLog(const fs::path& file, const std::atomic<bool>& cancel) {
  std::ifstream in(file, std::ios::binary);
  if (!in) throw std::runtime_error(file.string() + ": cannot read: " + std::strerror(errno));
  Replacement compressed(file.string() + ".gz", kPartial);
  const fs::path& part = compressed.draft();
  {
    // Level 1: of 40 s of all channels (16.7 MB) it leaves 38 % for 0.19 s of CPU, level 6 36 % for 0.31 s. zstd -3
    // leaves 29 % for 0.06 s, but the tools that people have read gzip.
    Compressed out{gzopen(part.c_str(), "wb1")};
    if (out.file == nullptr) throw std::runtime_error(part.string() + ": cannot write: " + std::strerror(errno));
    std::vector<char> block(1 << 18);
    while (in.read(block.data(), static_cast<std::streamsize>(block.size())), in.gcount() > 0) {
      const auto size = static_cast<unsigned>(in.gcount());
      if (gzwrite(out.file, block.data(), size) != static_cast<int>(size))
        throw std::runtime_error(part.string() + ": cannot write: " + std::strerror(errno));
      if (cancel) return;
    }
    if (in.bad()) throw std::runtime_error(file.string() + ": cannot read all of it");
    if (gzclose(std::exchange(out.file, nullptr)) != Z_OK)
      throw std::runtime_error(part.string() + ": cannot write: " + std::strerror(errno));
  }
  AppendFile(part, AppendFile::kAll).sync();
  fs::last_write_time(part, fs::last_write_time(file));  // when the log ended
  compressed.putInPlace();
  fs::remove(file);
}

}  // namespace slam
